//! The parameters that a model was built with, as 64-bit words that can be compared.

use super::scalar::Scalar;
use super::state::Motion;

/// Lists the parameters that a model was built with, so that two of one type can be compared bit by bit.
///
/// Scenes are simulated side by side (SIMD) only if their law lists its parameters. With an empty implementation they run one by one:
///
/// ```
/// # #[derive(Clone, Copy)] struct Quiet;
/// impl cohold_core::num::Configured for Quiet {}
/// ```
pub trait Configured {
    /// Calls `each` for every word, always in the same order; false if something is left out, as everything is by default.
    fn configuration(&self, _each: &mut dyn FnMut(u64)) -> bool {
        false
    }
}

/// Implements [`Configured`](crate::num::Configured) for a struct: its generics, its type, and all of its fields; those that follow
/// from the others, such as an initial state, are named after a semicolon and left out. A field that is missing does not compile.
///
/// ```
/// use cohold_core::{configured, law::Spring, num::Scalar};
///
/// struct Predict<S> {
///     spring: Spring<S>,
///     ahead: S,
///     stops: bool,
/// }
/// configured!([S: Scalar] Predict<S> { spring, ahead, stops });
/// ```
#[macro_export]
macro_rules! configured {
    ([$($generics:tt)*] $Type:ty { $($field:ident),* $(; $($state:ident),+)? }) => {
        impl<$($generics)*> $crate::num::Configured for $Type {
            fn configuration(&self, _each: &mut dyn FnMut(u64)) -> bool {
                let Self { $($field,)* $( $($state: _),+ )? } = self;
                true $( & $crate::num::Configured::configuration($field, _each) )*
            }
        }
    };
}

impl<S: Scalar> Configured for S {
    fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
        each(self.bits());
        true
    }
}

/// Implements [`Configured`] for what is one word.
macro_rules! word {
    ($($Type:ty),+) => { $(
        impl $crate::num::Configured for $Type {
            fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
                each(*self as u64);
                true
            }
        }
    )+ };
}
pub(crate) use word;
word!(bool, u16, u32, usize, i32);

configured!([S: Scalar] Motion<S> { position, velocity });

impl<T: Configured, const N: usize> Configured for [T; N] {
    fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
        self.iter().fold(true, |whole, one| whole & one.configuration(each))
    }
}

impl<T: Configured> Configured for (T, T) {
    fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
        self.0.configuration(each) & self.1.configuration(each)
    }
}

impl<T: Configured> Configured for Option<T> {
    fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
        self.is_some().configuration(each) & self.as_ref().is_none_or(|one| one.configuration(each))
    }
}
