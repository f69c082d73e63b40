//! What must be true of the wiring, build by build: each broken rule is a sentence.
//!
//! Levels are those that a net's own pins drive and bear. What reaches a pin through a resistor is no level of this kind: the divider
//! before PB1 and the resistor that empties the capacitor are reckoned in the tests, from the values that the netlist has.

use std::collections::{BTreeMap, BTreeSet};

use crate::netlist::{Is, Net, Netlist, Pull, Role, Symbol, split};

/// All that is wrong; nothing, if the wiring may be built.
pub fn wrong(netlist: &Netlist) -> Vec<String> {
    let mut wrong = listed(netlist);
    for build in netlist.build.keys() {
        let found = built(netlist, build).unwrap_or_else(|what| vec![what]);
        wrong.extend(found.into_iter().map(|what| format!("{build}: {what}")));
    }
    wrong
}

/// Parts list and drawings against the parts.
fn listed(netlist: &Netlist) -> Vec<String> {
    let mut wrong = Vec::new();
    for part in netlist.part.keys() {
        match netlist.buy.iter().filter(|buy| buy.parts.contains(part)).count() {
            1 => {}
            lines => wrong.push(format!("{part} is on {lines} lines of the parts list, must be on one")),
        }
        let on_sheet = |sheet: &crate::netlist::Sheet| sheet.columns.iter().flatten().any(|of| of == part);
        if !netlist.sheet.iter().any(on_sheet) {
            wrong.push(format!("{part} is on no drawing"));
        }
    }
    let bought = netlist.buy.iter().flat_map(|buy| &buy.parts).filter(|part| !netlist.part.contains_key(*part));
    wrong.extend(bought.map(|part| format!("the parts list has {part}, which is in no net")));
    let unknown = netlist.net.iter().flat_map(|net| &net.builds).filter(|build| !netlist.build.contains_key(*build));
    wrong.extend(unknown.map(|build| format!("there is no build {build}")));
    for pin in netlist.board.pins.iter().filter(|pin| pin.pull.is_some_and(|pull| pull != Pull::None)) {
        if pin.volts.is_some_and(|volts| volts > 3.6) {
            wrong.push(format!("{} has a pull inside the chip, and bears 3.6 V then, not {:?}", pin.pin, pin.volts));
        }
    }
    wrong
}

/// One build.
fn built(netlist: &Netlist, build: &str) -> Result<Vec<String>, String> {
    let nets = netlist.nets(build);
    let mut roles = BTreeMap::new();
    for part in netlist.part.keys().filter(|part| netlist.has(build, part)) {
        roles.extend(netlist.pins(part)?.into_iter().map(|(pin, role)| (format!("{part}.{pin}"), role)));
    }
    let mut wrong = Vec::new();
    let mut used: BTreeMap<&str, &str> = BTreeMap::new();
    for net in &nets {
        let mut here = Vec::new();
        for pin in &net.pins {
            match roles.get(pin) {
                Some(role) => here.push((pin.as_str(), *role)),
                None => wrong.push(format!("{} has {pin}, which is no pin of a part of this build", net.name)),
            }
            if let Some(other) = used.insert(pin, &net.name) {
                wrong.push(format!("{pin} is in {other} and in {}", net.name));
            }
        }
        wrong.extend(joined(net, &here));
    }
    wrong.extend(ends(netlist, build, &roles, &used));
    wrong.extend(grounds(netlist, build, &nets));
    wrong.extend(kept_off(netlist, &nets));
    Ok(wrong)
}

/// Ends, drivers and levels of one net.
fn joined(net: &Net, pins: &[(&str, Role)]) -> Vec<String> {
    let name = &net.name;
    let mut wrong = Vec::new();
    if pins.len() < 2 {
        wrong.push(format!("{name} has {} ends, must have two or more", pins.len()));
    }
    let all = |is: fn(Role) -> bool| pins.iter().filter(|(_, role)| is(*role)).map(|(pin, _)| *pin).collect::<Vec<_>>();
    let drivers = all(|role| matches!(role, Role::Out(_) | Role::Source(_)));
    let drains = all(|role| matches!(role, Role::Drain(_)));
    let (grounds, plugs) = (all(|role| role == Role::Ground), all(|role| role == Role::Plug));
    let other = !drains.is_empty() || !grounds.is_empty();
    if drivers.len() > 1 || (!drivers.is_empty() && other) {
        let both = [drivers.clone(), drains.clone(), grounds.clone()].concat();
        wrong.push(format!("{name}: {} drive each other", both.join(" and ")));
    }
    if !plugs.is_empty() && plugs.len() != pins.len() {
        wrong.push(format!("{name}: a socket meets a bare wire"));
    }
    let passive = pins.iter().any(|(_, role)| *role == Role::Passive);
    let driven = passive || other || !drivers.is_empty();
    let volts =
        pins.iter().map(|(_, role)| if let Role::Out(volts) | Role::Source(volts) = role { *volts } else { 0.0 });
    let most = volts.fold(0.0, f64::max);
    for (pin, role) in pins {
        if let Role::In(bears) | Role::Drain(bears) | Role::Supply(bears) = role {
            if !driven {
                wrong.push(format!("{name}: nothing drives {pin}"));
            }
            if most > *bears {
                wrong.push(format!("{name} is driven to {most} V, and {pin} bears {bears} V"));
            }
        }
    }
    wrong
}

/// Every pin has a wire or is said to be open, not both.
fn ends(netlist: &Netlist, build: &str, roles: &BTreeMap<String, Role>, used: &BTreeMap<&str, &str>) -> Vec<String> {
    let image = netlist.build[build].image;
    let mut wrong = Vec::new();
    for pin in roles.keys() {
        let (part, name) = split(pin);
        let chip = netlist.board.pins.iter().find(|chip| chip.pin == name);
        let open = match (netlist.part[part].kind.as_str(), chip) {
            ("board", Some(chip)) if !chip.image.has(image) => {
                if used.contains_key(pin.as_str()) {
                    wrong.push(format!("{pin} has a wire, and this image does not use it"));
                }
                continue;
            }
            // Supplies and sockets of the Nucleo need no wire, nor does a second board, which is wired as the first.
            ("board", None) => continue,
            ("board", Some(_)) if part != "N1" => continue,
            ("board", Some(_)) => netlist.build[build].open.iter().any(|of| of == name),
            _ => netlist.part[part].open.iter().any(|of| of == name),
        };
        // A strap is open on board 1.
        let strap = build == "bare" && name == "PG12";
        match (used.get(pin.as_str()), open || strap) {
            (None, false) => wrong.push(format!("{pin} has no wire, and is not said to be open")),
            (Some(net), true) => wrong.push(format!("{pin} is said to be open, and is in {net}")),
            _ => {}
        }
    }
    let chip: BTreeSet<&str> =
        netlist.board.pins.iter().filter(|pin| pin.is != Is::Board).map(|pin| pin.pin.as_str()).collect();
    let unknown = netlist.build[build].open.iter().filter(|pin| !chip.contains(pin.as_str()));
    wrong.extend(unknown.map(|pin| format!("{pin} is said to be open, and is no pin")));
    wrong
}

/// Signal and power grounds are two nets that meet in the star alone.
fn grounds(netlist: &Netlist, build: &str, nets: &[Net]) -> Vec<String> {
    if build == "bare" {
        return Vec::new();
    }
    let of = |pin: &str| nets.iter().find(|net| net.pins.iter().any(|of| of == pin)).map(|net| net.name.as_str());
    let stars: Vec<&String> =
        netlist.part.keys().filter(|part| netlist.has(build, part) && netlist.drawn(part).0 == Symbol::Star).collect();
    let [star] = stars.as_slice() else { return vec![format!("there are {} star points, must be one", stars.len())] };
    let (one, two) = (of(&format!("{star}.1")), of(&format!("{star}.2")));
    let mut wrong = Vec::new();
    if one == two || one != of("N1.GND") || two != of("G1.-") {
        wrong.push(format!("{star} does not join the ground of the board and that of the supply"));
    }
    wrong
}

/// Whatever enables a bridge or an amplifier is held low by a resistor while nothing drives it; with a gate, each of its inputs is.
fn kept_off(netlist: &Netlist, nets: &[Net]) -> Vec<String> {
    let grounded = |pin: &str| {
        let (part, end) = split(pin);
        let other = format!("{part}.{}", if end == "1" { "2" } else { "1" });
        let ground = |net: &&Net| net.pins.contains(&other) && matches!(net.name.as_str(), "0 V" | "power 0 V");
        netlist.drawn(part).0 == Symbol::Resistor && nets.iter().any(|net| ground(&net))
    };
    let enables = |pin: &String| {
        let (part, name) = split(pin);
        matches!((netlist.part[part].kind.as_str(), name), ("bridge", "nSLEEP") | ("gate", "A" | "B"))
    };
    let must = nets.iter().filter(|net| net.pins.iter().any(enables));
    let mut wrong: Vec<String> = must
        .filter(|net| !net.pins.iter().any(|pin| grounded(pin)))
        .map(|net| format!("{}: no resistor holds it low while the chip is in reset", net.name))
        .collect();
    // Low is all of the current backwards to an amplifier: what enables it must fall with the timer's outputs (board/gate.rs).
    let kind = |pin: &String| (netlist.part[split(pin).0].kind.clone(), split(pin).1.to_owned());
    let has =
        |net: &Net, of: &str, name: &str| net.pins.iter().any(|pin| kind(pin) == (of.to_owned(), name.to_owned()));
    let gated = ["PF3", "PE14"].iter().all(|input| {
        nets.iter().any(|net| has(net, "board", input) && (has(net, "gate", "A") || has(net, "gate", "B")))
    });
    let enabled = nets.iter().filter(|net| has(net, "amplifier", "ENABLE"));
    wrong.extend(
        enabled
            .filter(|net| !(gated && has(net, "gate", "Y") && has(net, "board", "PD15")))
            .map(|net| format!("{}: no gate of PF3 and PE14, seen by PD15, enables the amplifiers", net.name)),
    );
    wrong
}
