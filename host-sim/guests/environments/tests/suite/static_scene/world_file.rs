//! World files: what is read, and what is refused in one line that says where, what and what is allowed.

use cohold_environments::records::Shape;
use cohold_environments::world::{load, parse};

pub(crate) const TWO_ROOMS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../scenes/worlds/two-rooms.toml");

#[test]
fn the_world_in_the_repository() {
    let world = load(TWO_ROOMS.as_ref()).expect("a good world");
    assert_eq!((world.version, world.objects().len(), world.regions().len()), (1, 7, 2));
    assert_eq!(world.regions().iter().map(|region| region.server).collect::<Vec<_>>(), [1, 2]);
    let Some(Shape::Body(body)) = world.get(11).map(|object| object.shape) else { panic!("object 11 is a body") };
    assert_eq!((body.stiffness_n_per_m, body.damping_n_s_per_m), (600.0, 2.0));
}

#[track_caller]
fn refused(text: &str, wanted: &str) {
    let error = parse(text, "w.toml").expect_err("a bad world").to_string();
    assert_eq!(error, wanted);
}

#[test]
fn what_is_wrong_is_named() {
    refused(
        "[[wall]]\nid = 1\n\nthickness_m = -1",
        "w.toml:4: wall 1: thickness_m = -1 is not allowed: it must be a number from 0.001 to 1000 m",
    );
    refused(
        "[[body]]\nid = 1\nradius_m = \"big\"",
        "w.toml:3: body 1: radius_m = \"big\" is not allowed: it must be a number from 0.0001 to 1000 m",
    );
    refused(
        "[[body]]\nid = 1\nmass_kg = nan",
        "w.toml:3: body 1: mass_kg = nan is not allowed: it must be a number from 0.0001 to 1000 kg",
    );
    refused(
        "[[strip]]\nid = 1\nmasses = 2.5",
        "w.toml:3: strip 1: masses = 2.5 is not allowed: it must be a whole number from 1 to 64",
    );
    refused("[[body]]\nx_m = 1", "w.toml:1: body: id is missing");
    refused(
        "[[body]]\nid = -1",
        "w.toml:2: body: id = -1 is not allowed: it must be a whole number from 0 to 16777215",
    );
    refused(
        "[[body]]\nid = 1\n[[wall]]\nid = 1",
        "w.toml:1: body 1: id = 1 is wall 1's already: every object has its own",
    );
    refused(
        "[[wall]]\nid = 1\nto_x_m = 0.0",
        "w.toml:1: wall 1: from and to are the same point: it must have a length",
    );
    refused("[wall]\nid = 1", "w.toml:1: wall must be a list of tables: write [[wall]]");
    refused("margin_m = -0.1", "w.toml:1: world: margin_m = -0.1 is not allowed: it must be a number from 0 to 1000 m");
    refused(
        "[[ball]]\nid = 1",
        "w.toml:1: there is no key ball in a world; the keys are version, margin_m, region, wall, body, strip, block",
    );
    refused(
        "[[body]]\nid = 1\nradius = 1",
        "w.toml:3: there is no key radius in body 1; the keys are id, version, x_m, y_m, x_m_per_s, y_m_per_s, radius_m, mass_kg, drag_n_s_per_m, stiffness_n_per_m, damping_n_s_per_m",
    );
    // 0.25·T·(5000·T + 2·0.2) with T = 1 ms.
    refused(
        "[[strip]]\nid = 1\nmass_kg = 0.001",
        "w.toml:1: strip 1: mass_kg = 0.001 is not allowed: with these springs and dampers it must be above 1.350e-3 kg",
    );
    // 0.1 m square unless it says otherwise: b and c in the wrong order, then d on the line from a to c, and nothing at all.
    refused(
        "[[block]]\nid = 1\nb_y_m = 0.1\nc_y_m = 0",
        "w.toml:1: block 1: its sides cross: name the corners a, b, c, d in order around it",
    );
    let line = "[[block]]\nid = 1\nc_y_m = 0\nc_x_m = 0.2\nd_y_m = 0";
    refused(line, "w.toml:1: block 1: its sides enclose nothing: it must have an area");
    assert!(parse("[[block]]\nid = 1\nd_x_m = 0.1\n", "").is_ok(), "a triangle");
    let region = "[[region]]\nserver = 1\nfrom_x_m = 0\nfrom_y_m = 0\nto_x_m = 2\nto_y_m = 2\n";
    refused(
        &region.replace("to_x_m = 2", "to_x_m = 0"),
        "w.toml:1: region 1: from_x_m and from_y_m must be below to_x_m and to_y_m",
    );
    refused(
        &region.replace("server = 1", "server = 0"),
        "w.toml:2: region 1: server = 0 is not allowed: it must be a whole number from 1 to 254",
    );
    refused(&region.replace("server = 1\n", ""), "w.toml:1: region 1: server is missing");
    let other = region.replace("from_x_m = 0", "from_x_m = 1");
    refused(&format!("{region}{other}"), "w.toml:7: region 2 overlaps region 1: a place has one server");
    assert!(
        parse(
            &format!("{region}{}", region.replace("from_x_m = 0", "from_x_m = 2").replace("to_x_m = 2", "to_x_m = 3")),
            ""
        )
        .is_ok()
    );
    let syntax = parse("version = = 1", "w.toml").expect_err("no TOML").to_string();
    assert!(syntax.starts_with("w.toml:1: ") && !syntax.contains('\n'), "{syntax}");
    let gone = load("/no/such/world.toml".as_ref()).expect_err("no file").to_string();
    assert!(gone.starts_with("cannot read /no/such/world.toml"), "{gone}");
    let many: String = (0..1025).map(|id| format!("[[body]]\nid = {id}\n")).collect();
    refused(&many, "w.toml:2049: no room for more than 1024 objects");
}
