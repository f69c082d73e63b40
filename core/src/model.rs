//! The trait of models that settings choose by name (mechanisms, velocity estimators, contact renderings, integrators),
//! and `list!`, which makes one enum of all models that serve one purpose: the only place where they are named.
//!
//! A list holds a model together with its state, so that no model can be given the state of another, and `each!` calls
//! the chosen one. Coordination laws have a list of their own ([`crate::law::AnyLaw`]): their names are open.

use crate::num::{Configured, StateVector};
use crate::settings::{Refused, Settings};

/// A model that a list can hold: built once from settings, with a state of its own that begins at its default.
pub trait Model<S>: Configured + Copy + core::fmt::Debug + Send + Sync + 'static {
    /// State of the model.
    type State: StateVector<S> + Copy + core::fmt::Debug + Default + Send + Sync;

    /// Takes what it needs from settings that are within their ranges.
    ///
    /// # Errors
    /// Settings that are impossible beside each other.
    fn build(settings: &Settings) -> Result<Self, Refused<'static>>;
}

macro_rules! list {
    (
        $(#[$doc:meta])*
        $Any:ident, named by $Name:ident in $table:ident.$key:ident { $( $Variant:ident($model:ty), )+ }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        #[allow(missing_docs, clippy::large_enum_variant)]
        pub enum $Any<S: $crate::num::Scalar> { $( $Variant($model, <$model as $crate::model::Model<S>>::State) ),+ }

        impl<S: $crate::num::Scalar> $Any<S> {
            /// The model that the settings name, in its initial state.
            ///
            /// # Errors
            /// The model's key whose value is out of range or impossible beside the others.
            pub fn build(settings: &$crate::settings::Settings) -> Result<Self, $crate::settings::Refused<'static>> {
                Ok(match settings.$table.$key {
                    $( $Name::$Variant => {
                        Self::$Variant(<$model as $crate::model::Model<S>>::build(settings)?, Default::default())
                    } )+
                })
            }
        }

        /// Which one it is, and what that was built with.
        impl<S: $crate::num::Scalar> $crate::num::Configured for $Any<S> {
            fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
                match self { $(
                    Self::$Variant(model, _) => {
                        $crate::num::Configured::configuration(&$Name::$Variant, each)
                            & $crate::num::Configured::configuration(model, each)
                    }
                ),+ }
            }
        }

        impl<S: $crate::num::Scalar> $crate::num::StateVector<S> for $Any<S> {
            #[inline]
            fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
                match self { $( Self::$Variant(_, state) => $crate::num::StateVector::visit(state, each) ),+ }
            }
        }
    };
}

/// Calls the model that a list holds, with its state or without one.
macro_rules! each {
    ($self:ident: $($Variant:ident)|+, $model:ident => $call:expr) => {
        match $self { $( Self::$Variant($model, ..) => $call ),+ }
    };
    ($self:ident: $($Variant:ident)|+, $model:ident, $state:ident => $call:expr) => {
        match $self { $( Self::$Variant($model, $state) => $call ),+ }
    };
}
