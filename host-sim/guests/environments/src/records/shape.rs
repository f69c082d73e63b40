//! Shapes: what an object is made of, as up to 11 numbers with a name, a unit and a range each.
//!
//! One list declares them; records, checks and world files all read it. A new shape is one entry here, its outline in
//! [`Shape::bounds`], and a renderer.
//!
//! A wall and a strip go from one point to another; the free side is on the left of that way.

use core::fmt;

use cohold_protocol::bytes::layout;

/// What one number of a shape may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Its name, unit included.
    pub name: &'static str,
    /// The value where a file says nothing.
    pub default: f32,
    /// The least that is allowed.
    pub min: f32,
    /// The most that is allowed.
    pub max: f32,
    /// Whether only whole numbers are allowed.
    pub whole: bool,
    /// Unit of the number; empty for a pure one.
    pub unit: &'static str,
    /// Meaning of the number.
    pub doc: &'static str,
}

impl Field {
    /// Whether `value` is allowed.
    pub fn allows(&self, value: f32) -> bool {
        value >= self.min && value <= self.max && (!self.whole || value == (value as u32) as f32)
    }
}

/// A number of a shape that is out of its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{shape}.{} = {value} is not allowed: it must be {field}", field.name)]
pub struct Refused {
    /// Name of the shape.
    pub shape: &'static str,
    /// The number that was refused, with its range.
    pub field: &'static Field,
    /// The value that was offered.
    pub value: f32,
}

/// The range in words, with its unit.
impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.whole { "a whole number" } else { "a number" };
        write!(f, "{kind} from {} to {}", self.min, self.max)?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

macro_rules! shapes {
    ($(
        $(#[$doc:meta])*
        $kind:literal $name:literal => $Shape:ident {
            $( #[doc = $field_doc:literal] $field:ident = $default:literal, $range:expr, $unit:literal; )+
        }
    )+) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, PartialEq)]
            pub struct $Shape { $( #[doc = concat!($field_doc, " Unit: ", $unit, ".")] pub $field: f32, )+ }

            impl Default for $Shape {
                fn default() -> Self {
                    Self { $( $field: $default ),+ }
                }
            }
        )+

        /// What an object is made of.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Shape { $( $(#[$doc])* $Shape($Shape), )+ }

        impl Shape {
            /// Name, kind in a record, and numbers of every shape, in order.
            pub const ALL: &'static [(&'static str, u8, &'static [Field])] = &[$(($name, $kind, &[$({
                let (min, max, whole) = $range;
                Field { name: stringify!($field), default: $default, min, max, whole, unit: $unit, doc: $field_doc }
            },)+])),+];

            /// Kind in a record.
            pub fn kind(&self) -> u8 {
                match self { $( Self::$Shape(_) => $kind ),+ }
            }

            /// The numbers in order, then 0.
            pub fn numbers(&self) -> [f32; Shape::NUMBERS] {
                let mut all = [0.0; Shape::NUMBERS];
                match self { $( Self::$Shape(shape) => {
                    for (to, from) in all.iter_mut().zip([$(shape.$field),+]) {
                        *to = from;
                    }
                } )+ }
                all
            }

            /// The shape of this kind that has these numbers, each within its range; `None`: there is no such kind.
            ///
            /// # Errors
            /// The first number that is out of its range.
            pub fn build(kind: u8, numbers: &[f32; Shape::NUMBERS]) -> Option<Result<Self, Refused>> {
                let (shape, _, fields) = Self::ALL.iter().find(|(_, known, _)| *known == kind)?;
                for (field, value) in fields.iter().zip(numbers) {
                    if !field.allows(*value) {
                        return Some(Err(Refused { shape, field, value: *value }));
                    }
                }
                let mut rest = numbers.iter().copied();
                match kind {
                    $( $kind => Some(Ok(Self::$Shape($Shape { $( $field: rest.next().unwrap_or($default) ),+ }))), )+
                    _ => None,
                }
            }
        }
    };
}

const fn number(min: f32, max: f32) -> (f32, f32, bool) {
    (min, max, false)
}
const fn whole(min: f32, max: f32) -> (f32, f32, bool) {
    (min, max, true)
}
const fn place() -> (f32, f32, bool) {
    number(-1000.0, 1000.0)
}

shapes! {
    /// A solid that never moves: a rectangle behind its face.
    1 "wall" => Wall {
        #[doc = "Where the face begins."] from_x_m = 0.0, place(), "m";
        #[doc = "Where the face begins."] from_y_m = 0.0, place(), "m";
        #[doc = "Where the face ends; the free side is on the left."] to_x_m = 1.0, place(), "m";
        #[doc = "Where the face ends."] to_y_m = 0.0, place(), "m";
        #[doc = "Depth of the rectangle behind the face."] thickness_m = 0.1, number(0.001, 1000.0), "m";
        #[doc = "Contact stiffness."] stiffness_n_per_m = 1000.0, number(0.0, 1e6), "N/m";
        #[doc = "Contact damping."] damping_n_s_per_m = 2.0, number(0.0, 1e4), "N·s/m";
    }
    /// A round body that can be moved where an architecture lets users move things; in a static world it stays.
    2 "body" => Body {
        #[doc = "Position of the centre."] x_m = 0.0, place(), "m";
        #[doc = "Position of the centre."] y_m = 0.0, place(), "m";
        #[doc = "Velocity."] x_m_per_s = 0.0, number(-100.0, 100.0), "m/s";
        #[doc = "Velocity."] y_m_per_s = 0.0, number(-100.0, 100.0), "m/s";
        #[doc = "Radius."] radius_m = 0.02, number(1e-4, 1000.0), "m";
        #[doc = "Mass."] mass_kg = 0.3, number(1e-4, 1e3), "kg";
        #[doc = "Viscous damping of its motion."] drag_n_s_per_m = 0.0, number(0.0, 1e4), "N·s/m";
        #[doc = "Contact stiffness."] stiffness_n_per_m = 1000.0, number(0.0, 1e6), "N/m";
        #[doc = "Contact damping."] damping_n_s_per_m = 2.0, number(0.0, 1e4), "N·s/m";
    }
    /// A deformable strip: a chain of masses between two fixed ends, each held to its neighbours by a spring across.
    3 "strip" => Strip {
        #[doc = "Fixed end."] from_x_m = 0.0, place(), "m";
        #[doc = "Fixed end."] from_y_m = 0.0, place(), "m";
        #[doc = "Other fixed end; the free side is on the left."] to_x_m = 0.1, place(), "m";
        #[doc = "Other fixed end."] to_y_m = 0.0, place(), "m";
        #[doc = "Masses between the ends."] masses = 9.0, whole(1.0, 64.0), "";
        #[doc = "Each mass."] mass_kg = 0.01, number(1e-4, 1e3), "kg";
        #[doc = "Stiffness of the spring between neighbours."] spring_n_per_m = 1000.0, number(0.0, 1e6), "N/m";
        #[doc = "Viscous damping of each mass."] drag_n_s_per_m = 0.2, number(0.0, 1e4), "N·s/m";
        #[doc = "Contact stiffness."] stiffness_n_per_m = 1000.0, number(0.0, 1e6), "N/m";
        #[doc = "Contact damping."] damping_n_s_per_m = 0.0, number(0.0, 1e4), "N·s/m";
    }
    /// A solid with four straight sides that never moves; three, where two neighbouring corners are the same.
    4 "block" => Block {
        #[doc = "First corner."] a_x_m = 0.0, place(), "m";
        #[doc = "First corner."] a_y_m = 0.0, place(), "m";
        #[doc = "The next one around the block, either way around."] b_x_m = 0.1, place(), "m";
        #[doc = "The next one."] b_y_m = 0.0, place(), "m";
        #[doc = "The next one."] c_x_m = 0.1, place(), "m";
        #[doc = "The next one."] c_y_m = 0.1, place(), "m";
        #[doc = "The last one."] d_x_m = 0.0, place(), "m";
        #[doc = "The last one."] d_y_m = 0.1, place(), "m";
        #[doc = "Contact stiffness."] stiffness_n_per_m = 1000.0, number(0.0, 1e6), "N/m";
        #[doc = "Contact damping."] damping_n_s_per_m = 2.0, number(0.0, 1e4), "N·s/m";
    }
}

impl Block {
    /// The corners, in order around it, m.
    pub fn corners(&self) -> [[f32; 2]; 4] {
        [[self.a_x_m, self.a_y_m], [self.b_x_m, self.b_y_m], [self.c_x_m, self.c_y_m], [self.d_x_m, self.d_y_m]]
    }
}

layout! {
    /// A rectangle along the axes: where it begins and ends in x and y, m.
    pub struct Bounds(16 bytes) {
        0 => min: [f32; 2], "Least x and y.";
        8 => max: [f32; 2], "Largest x and y.";
    }
}

impl Bounds {
    /// The rectangle around two points, and this much more on every side.
    pub fn around(a: [f32; 2], b: [f32; 2], more: f32) -> Self {
        let [[ax, ay], [bx, by]] = [a, b];
        Self { min: [ax.min(bx) - more, ay.min(by) - more], max: [ax.max(bx) + more, ay.max(by) + more] }
    }

    /// The rectangle around both.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let ([ax, ay], [bx, by]) = (self.min, self.max);
        let ([cx, cy], [dx, dy]) = (other.min, other.max);
        Self { min: [ax.min(cx), ay.min(cy)], max: [bx.max(dx), by.max(dy)] }
    }

    /// Whether the two have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        let ([ax, ay], [bx, by]) = (self.min, self.max);
        let ([cx, cy], [dx, dy]) = (other.min, other.max);
        ax <= dx && cx <= bx && ay <= dy && cy <= by
    }

    /// Whether the point is within `reach` of the rectangle.
    pub fn within(&self, [x, y]: [f32; 2], reach: f32) -> bool {
        let ([ax, ay], [bx, by]) = (self.min, self.max);
        let beyond = |at: f32, min: f32, max: f32| (min - at).max(at - max).max(0.0);
        let (dx, dy) = (beyond(x, ax, bx), beyond(y, ay, by));
        dx * dx + dy * dy <= reach * reach
    }
}

impl Shape {
    /// Room for numbers in a record.
    pub const NUMBERS: usize = 11;

    /// A rectangle that the whole shape lies in. A strip may be pushed as far from its line as it is long.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Wall(wall) => {
                Bounds::around([wall.from_x_m, wall.from_y_m], [wall.to_x_m, wall.to_y_m], wall.thickness_m)
            }
            Self::Body(body) => Bounds::around([body.x_m, body.y_m], [body.x_m, body.y_m], body.radius_m),
            Self::Strip(strip) => {
                let length = (strip.to_x_m - strip.from_x_m).abs() + (strip.to_y_m - strip.from_y_m).abs();
                Bounds::around([strip.from_x_m, strip.from_y_m], [strip.to_x_m, strip.to_y_m], length)
            }
            Self::Block(block) => {
                let [a, b, c, d] = block.corners();
                Bounds::around(a, b, 0.0).and(&Bounds::around(c, d, 0.0))
            }
        }
    }
}
