// The printed parts of docs/paddle.md. The numbers are in numbers.scad, which is made of firmware/wiring/paddle/numbers.toml.
//
//   for part in base sector guard grip sleeve; do openscad -D "part=\"$part\"" -o $part.stl paddle.scad; done
//
// Each part lies as it is printed: 0.2 mm layers, 4 walls, 40 % infill, PETG. The guard needs supports in its slit, the others none. x to the right, y from the paddle's axis
// to the drum, z up, 0 at the upper side of the base.

include <numbers.scad>

part = "all";           // base, sector, guard, grip, sleeve, or all of them assembled
turned = 0;             // degrees, of the sector in "all"
fit = 0.15;             // of a hole around what goes into it: try your printer with the sleeve first
$fn = 96;

plate_half = plate_wide / 2;
sector_half = sector_wide / 2;
sector_high = sector_top - sector_z;
sector_mid = (sector_top + sector_z) / 2;
bearing_apart = boss_high - 2 * bearing_high;
leg_x = plate_half - leg_in;
guard_half = guard_wide / 2;

module at_drum() { translate([0, centre, 0]) children(); }
module hole(diameter, from, to) { translate([0, 0, from]) cylinder(d = diameter, h = to - from); }

// A sector of a ring from radius `from` to `to`, between two angles from the y axis.
module ring(from, to, left, right) {
    steps = 48;
    polygon(concat(
        [for (i = [0 : steps]) let (a = left + (right - left) * i / steps) to * [sin(a), cos(a)]],
        from == 0 ? [[0, 0]] : [for (i = [steps : -1 : 0]) let (a = left + (right - left) * i / steps) from * [sin(a), cos(a)]]));
}

module base() {
    difference() {
        union() {
            translate([-plate_half, -plate_front, -plate]) cube([2 * plate_half, plate_front + plate_back, plate]);
            for (x = [-1, 1], y = [leg_in - plate_front, plate_back - leg_in]) translate([x * leg_x, y, 0]) hole(leg_wide, -plate - leg, -plate / 2);
            hole(boss, -boss_high, 0);
            at_drum() {
                hole(motor + 10, -plate - 30, -plate);
                // Ears of the clamp, towards the middle.
                translate([-8, -motor / 2 - 17, -plate - 30]) cube([16, 18, 30]);
            }
        }
        // Bearings from above and below, with a shoulder for their outer rings.
        hole(bearing + fit, -bearing_high, 1);
        hole(bearing + fit, -boss_high - 1, bearing_high - boss_high);
        hole(bearing - 4, -boss_high, 0);
        at_drum() {
            hole(motor + 2 * fit, -plate - 31, -motor_wall);
            hole(drum + 4, -plate, 1);
            // The clamp's slot, and its screw M4.
            translate([-1, -motor / 2 - 18, -plate - 31]) cube([2, 20, 31]);
            translate([-20, -motor / 2 - 11, -plate - 15]) rotate([0, 90, 0]) cylinder(d = 4.4, h = 40);
        }
        // Stops: screws M5 from below. Pins: a rod of 4 mm. Guard: screws M3. Legs: wood screws from below the board.
        for (side = [-1, 1]) {
            rotate(side * stop_angle) translate([0, stop_at, 0]) hole(5.3, -plate - 1, 1);
            for (y = [66, 84]) translate([side * (guard_half + 6), y, 0]) hole(3.3, -plate - 1, 1);
        }
        for (angle = [-pin_deg, 0, pin_deg]) rotate(180 + angle) translate([0, pin_at, 0]) hole(pin, -plate - 1, 1);
        for (x = [-1, 1], y = [leg_in - plate_front, plate_back - leg_in]) translate([x * leg_x, y, 0]) hole(3.2, -plate - leg - 1, -plate - 20);
    }
}

module sector() {
    difference() {
        union() {
            translate([0, 0, sector_z]) linear_extrude(sector_high) difference() {
                union() {
                    ring(0, sector, -sector_half, sector_half);
                    circle(d = hub);
                    translate([-arm / 2, -handle]) square([arm, handle]);
                    translate([0, -handle]) circle(d = arm + 4);
                }
                for (side = [-1, 1]) ring(window - window_deep / 2, window + window_deep / 2, side * window_from, side * (window_from + window_wide));
            }
            hole(hub, 1, sector_top);
            // Touches the inner ring of the bearing, and nothing else.
            hole(12, 0, 2);
        }
        hole(8 + 2 * fit, -1, sector_top + 1);
        translate([0, -handle, 0]) hole(10 + 2 * fit, 0, sector_top + 1);
        translate([0, -pin_at, 0]) hole(pin, 0, sector_top + 1);
        // The cable's ends: screws M3, cut into the plastic, 8 mm in from the rim, in the two faces.
        for (side = [-1, 1])
            rotate(-side * sector_half) translate([0, sector - 8, sector_mid]) rotate([0, -side * 90, 0])
                translate([0, 0, -1]) cylinder(d = 2.6, h = 15);
    }
}

module guard() {
    depth = guard_back - guard_front;
    difference() {
        union() {
            translate([-guard_half, guard_front, 0]) cube([2 * guard_half, depth, guard_high]);
            for (side = [-1, 1]) translate([side * (guard_half + 5) - 6, 60, 0]) cube([12, 29, guard_high]);
        }
        translate([-guard_half + guard_wall, guard_front + guard_wall, -1])
            cube([2 * (guard_half - guard_wall), depth - 2 * guard_wall, (guard_high - guard_wall) + 1]);
        // The sector swings through.
        hole(2 * (sector + 1), sector_z - slit, sector_top + slit);
        // The encoder: its shaft, and slots for hole circles of 16 to 22 mm.
        at_drum() {
            hole(13, 0, guard_high + 1);
            for (side = [0, 180]) rotate(side) hull() for (r = [8, 11]) translate([r, 0, 0]) hole(2.9, (guard_high - guard_wall) - 1, guard_high + 1);
        }
        // Screws M3, whose heads go 4 mm above the plate.
        for (side = [-1, 1], y = [66, 84]) translate([side * (guard_half + 6), y, 0]) {
            hole(3.4, -1, 5);
            hole(6.5, 4, guard_high + 1);
        }
    }
}

module grip() {
    difference() {
        hole(grip, 0, grip_long);
        hole(10 + 4 * fit, -1, grip_long + 1);
    }
}

// Between the inner rings of the bearings; a second one, 2 mm long, is below the lower bearing.
module sleeve(long = bearing_apart) {
    difference() {
        hole(12, 0, long);
        hole(8 + 2 * fit, -1, long + 1);
    }
}

// Bought: the drum, and the screws of the stops in their rubber hose.
module bought() {
    at_drum() hole(drum, drum_z, drum_z + drum_long);
    for (side = [-1, 1]) rotate(side * stop_angle) translate([0, stop_at, 0]) hole(stop, 4, 20);
}

if (part == "base") translate([0, 0, 0]) rotate([180, 0, 0]) base();
if (part == "sector") rotate([180, 0, 0]) translate([0, 0, -sector_top]) sector();
if (part == "guard") rotate([180, 0, 0]) translate([0, 0, -guard_high]) guard();
if (part == "grip") grip();
if (part == "sleeve") { sleeve(); translate([20, 0, 0]) sleeve(2); }
if (part == "all") {
    color("lightgray") base();
    color("skyblue") rotate(-turned) sector();
    color("palegreen", 0.5) guard();
    translate([0, -handle, sector_top + 8]) color("lavender") grip();
    at_drum() color("peru") hole(drum, drum_z, drum_z + drum_long);
    translate([0, 0, bearing_high - boss_high]) sleeve();
}
// For a check that nothing meets as it swings: between the stops nothing is left.
if (part == "meets") intersection() { rotate(-turned) sector(); union() { base(); guard(); bought(); } }
