//! Names of settings and options that are not the peer's own: one table a type, as in `cohold_core::names`.

/// Enums whose values have names: `"name" => Variant, "meaning";`, a line each. The order is that of [`cohold_core::names::Choice`].
#[doc(hidden)]
#[macro_export]
macro_rules! choices {
    ($( $(#[$attribute:meta])* $Name:ident { $( $name:literal => $Variant:ident, $meaning:literal; )+ } )+) => { $(
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $Name { $( #[doc = $meaning] $Variant ),+ }

        impl cohold_core::names::Choice for $Name {
            const NAMES: &'static [&'static str] = &[$($name),+];
            const ALL: &'static [Self] = &[$(Self::$Variant),+];
        }
    )+ };
}
