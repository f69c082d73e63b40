//! One list per kind of model: the place, and the only one, where a new law, integrator or estimator is named.
//!
//! `list!` turns the list into three things: the enum of names that a scene file may use, an enum that holds any one of
//! the models behind the trait they share, and the enum of their states. A scene that is fixed at compile time names the
//! model itself instead ([`crate::scene::Models`]) and then carries no other.
//!
//! A method that steps a state is written `fn step(&self, [&mut] state; input: Input) -> Output;` (`Output: Default`), one
//! that reads it `[&] state`, one without state `fn forward(&self; input: Input) -> Output;`.

/// A model that a list can hold: built once from settings, with a state of its own.
pub trait Model<S>: Copy + core::fmt::Debug + Sized {
    /// What changes from tick to tick.
    type State: crate::num::StateVector<S> + Copy + core::fmt::Debug + Default + PartialEq;

    /// What no single range can say: whether the settings that this model takes go together. Asked only of the model that
    /// the settings name.
    fn check(_: &crate::settings::Settings) -> Result<(), crate::settings::Refused<'static>> {
        Ok(())
    }

    /// Takes what it needs from settings that [`crate::settings::Settings::check`] has passed.
    fn build(settings: &crate::settings::Settings) -> Self;

    /// The state at rest.
    fn initial(&self) -> Self::State {
        Self::State::default()
    }
}

/// The names under which a list, or the one model that stands in for it, can be asked for.
pub trait Listed<S> {
    /// Scene-file names.
    const NAMES: &'static [&'static str];
}

macro_rules! list {
    (
        $(#[$doc:meta])*
        $trait:ident: $Any:ident, $State:ident, named by $Name:ident in $table:ident.$key:ident {
            $( $(#[$model_doc:meta])* $name:literal => $Variant:ident($model:ty) ),+ $(,)?
        }
        $( fn $method:ident(&self $(, [$($state_ref:tt)+] state)? $(; $($arg:ident: $arg_type:ty),+)?) $(-> $ret:ty)?; )*
    ) => {
        /// The names that a scene may use here.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)]
        pub enum $Name { $( $(#[$model_doc])* $Variant ),+ }

        impl $crate::settings::Choice for $Name {
            const NAMES: &'static [&'static str] = &[$($name),+];
            const ALL: &'static [Self] = &[$(Self::$Variant),+];
        }

        $( impl<S: $crate::num::Scalar> $crate::model::Listed<S> for $model {
            const NAMES: &'static [&'static str] = &[$name];
        } )+

        impl<S: $crate::num::Scalar> $crate::model::Listed<S> for $Any<S> {
            const NAMES: &'static [&'static str] = &[$($name),+];
        }

        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        #[allow(missing_docs, clippy::large_enum_variant)]
        pub enum $Any<S> { $( $Variant($model) ),+ }

        /// State of whichever model the scene named.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(missing_docs, clippy::large_enum_variant)]
        pub enum $State<S: $crate::num::Scalar> { $( $Variant(<$model as $crate::model::Model<S>>::State) ),+ }

        impl<S: $crate::num::Scalar> Default for $State<S> {
            fn default() -> Self {
                list!(@first $State $($Variant)+)
            }
        }

        impl<S: $crate::num::Scalar> $crate::num::StateVector<S> for $State<S> {
            #[inline]
            fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
                match self { $( Self::$Variant(state) => $crate::num::StateVector::visit(state, each) ),+ }
            }
        }

        impl<S: $crate::num::Scalar> $crate::model::Model<S> for $Any<S> {
            type State = $State<S>;
            fn check(settings: &$crate::settings::Settings) -> Result<(), $crate::settings::Refused<'static>> {
                match settings.$table.$key {
                    $( $Name::$Variant => <$model as $crate::model::Model<S>>::check(settings) ),+
                }
            }
            fn build(settings: &$crate::settings::Settings) -> Self {
                match settings.$table.$key {
                    $( $Name::$Variant => Self::$Variant(<$model as $crate::model::Model<S>>::build(settings)) ),+
                }
            }
            fn initial(&self) -> Self::State {
                match self { $( Self::$Variant(model) => $State::$Variant(<$model as $crate::model::Model<S>>::initial(model)) ),+ }
            }
        }

        list!(@methods $trait $Any $State { $($Variant)+ }
            $( $method [$($($state_ref)+)?] [$($($arg: $arg_type),+)?] [$(-> $ret)?] )*);
    };
    (@first $State:ident $first:ident $($rest:ident)*) => { $State::$first(Default::default()) };
    // The variants travel as one token tree, so that every method can repeat over all of them.
    (@methods $trait:ident $Any:ident $State:ident $variants:tt $( $method:ident $state_ref:tt $args:tt $ret:tt )*) => {
        impl<S: $crate::num::Scalar> $trait<S> for $Any<S> {
            $( list!{@method $trait $Any $State $variants $method $state_ref $args $ret} )*
        }
    };
    (@method $trait:ident $Any:ident $State:ident { $($Variant:ident)+ } $method:ident [] $args:tt $ret:tt) => {
        list!(@signature $method [] $args $ret this {
            match this { $( $Any::$Variant(model) => list!(@call $trait $method [model] $args) ),+ }
        });
    };
    (@method $trait:ident $Any:ident $State:ident { $($Variant:ident)+ } $method:ident [$($state_ref:tt)+] $args:tt $ret:tt) => {
        list!(@signature $method [state: $($state_ref)+ $State<S>] $args $ret this {
            match (this, state) {
                $( ($Any::$Variant(model), $State::$Variant(state)) => list!(@call $trait $method [model, state] $args), )+
                // A state that another model left behind cannot be stepped: answer with nothing.
                #[allow(unreachable_patterns)]
                _ => Default::default(),
            }
        });
    };
    (@signature $method:ident [$($state:ident: $state_type:ty)?] [$($arg:ident: $arg_type:ty),*] [$(-> $ret:ty)?] $this:ident $body:block) => {
        #[inline]
        fn $method(&self $(, $state: $state_type)? $(, $arg: $arg_type)*) $(-> $ret)? {
            let $this = self;
            $body
        }
    };
    (@call $trait:ident $method:ident [$($first:ident),+] [$($arg:ident: $arg_type:ty),*]) => {
        $trait::<S>::$method($($first),+ $(, $arg)*)
    };
}
