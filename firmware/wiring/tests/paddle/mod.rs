//! The paddle of docs/guides/board/paddle.md: what follows from its numbers, and the files that are made of them.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_4, TAU};

use crate::{place, text};

/// The numbers of paddle/numbers.toml and those that follow from them: mm, g, degrees, or the unit that a name ends with.
fn numbers() -> BTreeMap<String, f64> {
    let mut all: BTreeMap<String, f64> = toml::from_str(&text("paddle/numbers.toml")).unwrap();
    let given = all.clone();
    let n = |name: &str| given[name];
    let mut follows = |name: &str, value: f64| *all.entry(name.to_owned()).or_insert(value);
    let drum_radius = follows("drum_radius", (n("drum") + n("cable")) / 2.0);
    let sector_cable = follows("sector_cable", n("ratio") * drum_radius);
    let (sector, wide) = (follows("sector", sector_cable - n("cable") / 2.0), n("sector_wide").to_radians());
    follows("centre", sector_cable + drum_radius + n("gap"));
    follows("cable_long", wide * sector_cable + n("turns") * TAU * drum_radius);
    follows("rim_arc", wide / 2.0 * sector);
    follows("window_arc", n("window_wide").to_radians() * n("window"));
    follows("pin_deg", 180.0 / n("ratio"));
    follows("travel_deg", (n("travel") / n("handle")).to_degrees());
    let stop_deg = follows("stop_deg", ((n("travel") + n("overtravel")) / n("handle")).to_degrees());
    let touches_at = n("sector_wide") / 2.0 + stop_deg;
    follows("stop_angle", touches_at + (n("stop") / 2.0 / n("stop_at")).asin().to_degrees());
    // How far the motor turns for a metre of the handle, rad/m: an inertia J there is a mass J·(rad/m)² at the handle.
    let turns = 1e3 * n("ratio") / n("handle");
    follows("counts_per_m", n("counts_per_rev") / TAU * turns);
    follows("um_per_count", 1e6 * TAU / n("counts_per_rev") / turns);
    follows("no_load_m_per_s", n("speed_rpm_per_v") * n("supply_v") * TAU / 60.0 / turns);
    follows("encoder_m_per_s", n("encoder_rpm") * TAU / 60.0 / turns);
    let rotor_kg = follows("rotor_kg", 1e-7 * n("rotor_g_cm2") * turns.powi(2));
    let [outer, inner] = [n("drum").powi(2), n("shaft").powi(2)];
    let drum_g = 1e-3 * n("drum_g_per_cm3") * FRAC_PI_4 * (outer - inner) * n("drum_long");
    let drum_kg = follows("drum_kg", 1e-9 * drum_g * (outer + inner) / 8.0 * turns.powi(2));
    let g_per_mm2 = 1e-3 * n("print_g_per_cm3") * n("print_fill") * (n("sector_top") - n("sector_z"));
    // The whole fan, without its openings, and the arm.
    let sector_g_mm2 = g_per_mm2 * (wide / 4.0 * sector.powi(4) + n("arm") * n("handle").powi(3) / 3.0);
    let sector_kg = follows("sector_kg", 1e-3 * sector_g_mm2 / n("handle").powi(2));
    let apparent_kg = follows("apparent_kg", rotor_kg + drum_kg + sector_kg + n("handle_g") / 1e3);
    let n_per_a = follows("n_per_a", n("torque_nm_per_a") * turns);
    follows("continuous_n", n("continuous_a") * n_per_a);
    let peak_n = follows("peak_n", n("full_scale_a") * n("max_duty") * n_per_a);
    follows("pull_n", peak_n * n("handle") / sector_cable + n("preload_n"));
    // A bridge turns voltage into current: the supply's limit bounds the power, and a motor that stands still turns all of it to heat.
    let worst_a = follows("worst_a", (n("supply_v") * n("supply_a") / n("resistance_ohm")).sqrt());
    follows("worst_n", worst_a * n_per_a);
    let capacitor_j = follows("capacitor_j", n("capacitor_f") * n("supply_v").powi(2) / 2.0);
    follows("capacitor_m_per_s", (2.0 * capacitor_j / apparent_kg).sqrt());
    follows("winding_us", 1e6 * n("inductance_h") / n("resistance_ohm"));
    all
}

/// A template with `{name}` as two decimals, `{name:0}` as so many, and `{name/2}` as that share of it.
fn filled(template: &str) -> String {
    let (numbers, mut parts) = (numbers(), template.split('{'));
    let mut made = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (word, rest) = part.split_once('}').unwrap();
        let (word, digits) = word.split_once(':').unwrap_or((word, "2"));
        let (name, by) = word.split_once('/').unwrap_or((word, "1"));
        let value = numbers[name] / by.parse::<f64>().unwrap();
        made += &format!("{value:.*}{rest}", digits.parse().unwrap());
    }
    made
}

/// `COHOLD_BLESS=1 cargo test -p cohold-wiring --test suite paddle` writes them.
#[test]
fn the_paddle_is_what_its_numbers_say() {
    let mut page = text("../../docs/guides/board/paddle.md");
    for table in ["parts", "figures"] {
        let begin = format!("<!-- {table}: written by firmware/wiring/tests/paddle -->\n");
        let (before, rest) = page.split_once(&begin).unwrap();
        let (_, after) = rest.split_once("<!-- end").unwrap();
        page = format!("{before}{begin}{}<!-- end{after}", filled(&text(&format!("paddle/{table}.md"))));
    }
    let scad = numbers().iter().map(|(name, value)| format!("{name} = {value:.6};\n")).collect();
    let [drawing, settings] = ["drawing.svg", "settings.toml"].map(|file| filled(&text(&format!("paddle/{file}"))));
    let files = ["guides/board/paddle.md", "assembly-paddle.svg", "paddle/settings.toml", "paddle/numbers.scad"];
    for (file, now) in files.map(|file| format!("../../docs/{file}")).into_iter().zip([page, drawing, settings, scad]) {
        if std::env::var_os("COHOLD_BLESS").is_some() {
            std::fs::write(place(&file), &now).unwrap();
        }
        assert!(text(&file) == now, "{file} is another; COHOLD_BLESS=1 writes it");
    }
}

#[test]
fn the_paddle_fits_together_and_its_motor() {
    let (numbers, guide) = (numbers(), text("../../docs/guides/board/assembly.md"));
    let n = |name: &str| numbers[name];
    assert!((5.0..10.0).contains(&n("peak_n")) && n("worst_n") < 10.0 && (0.05..0.15).contains(&n("apparent_kg")));
    // At a stop the sector still fills the guard's slit, and the cable's turns stay on it as they move along the drum.
    let fills = n("guard_front") * (n("sector_wide") / 2.0 - n("stop_deg")).to_radians().tan();
    let moved = n("turns") + n("ratio") * n("stop_deg") / 180.0;
    assert!(fills > n("guard_wide") / 2.0 - n("guard_wall"), "{fills}");
    assert!(1.2 * n("cable") * moved < n("sector_top") - n("sector_z"));
    // No opening of the sector passes the guard's edge; the shaft is in the drum up to its middle; the winding is one that bring-up takes.
    assert!(n("window") + n("window_deep") / 2.0 < n("guard_front") && n("winding_us") > 40.0);
    assert!((6.0..=n("drum_long") / 2.0).contains(&(n("shaft_long") - n("motor_wall") - n("drum_z"))));
    let sheet = format!("--resistance-ohm {} --inductance-h {}", n("resistance_ohm"), n("inductance_h"));
    assert!(guide.contains(&sheet), "{sheet}");
}
