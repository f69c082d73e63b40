//! What the hand feels: the contact between the device and the local copy of the shared object.
//!
//! | module | holds |
//! |---|---|
//! | [`continuous`] | continuous rendering: a spring and a damper |
//! | [`impulsive`] | impulsive rendering: impacts between device and object, felt as pulses of a tick each, and rest |
//! | [`impact`] | impacts of round bodies and flat walls: time of impact, exchange of momentum |
//! | [`grip`] | how a contact gives way whose force is limited |

pub mod continuous;
pub mod grip;
pub mod impact;
pub mod impulsive;
mod rendering;

use crate::num::{Motion, Scalar};

pub use crate::names::{RenderingName, Side};
pub use continuous::Contact;
pub use grip::Grip;
pub use rendering::{Giving, Impacts, Press, Rendering, Strikes, Touch};

list! {
    /// Any rendering of contact.
    AnyRendering, named by RenderingName in contact.rendering {
        Continuous(Contact<S>),
        Impulsive(impulsive::Impulsive<S>),
    }
}

impl<S: Scalar> AnyRendering<S> {
    /// Where the object has to be to be just clear of a device at `position`, m ([`Rendering::clear_of`]).
    pub fn clear_of(&self, position: S) -> S {
        each!(self: Continuous | Impulsive, model => model.clear_of(position))
    }

    /// The spring and damper that it is while device and object press on each other.
    #[inline]
    pub fn spring(&self) -> &Contact<S> {
        match self {
            Self::Continuous(contact, ()) => contact,
            Self::Impulsive(impulsive, ()) => impulsive.spring(),
        }
    }

    /// [`Rendering::touch`], and the object's motion after any impacts. By value, so that a spring's stays in registers.
    #[inline]
    pub fn touch(
        &self,
        strikes: &mut Strikes<S>,
        device: Motion<S>,
        object: Motion<S>,
        giving: Giving<'_, S>,
    ) -> (Motion<S>, Touch<S>) {
        each!(self: Continuous | Impulsive, model => model.touch(strikes, device, object, giving))
    }

    /// One tick of the contact as a port ([`Rendering::press`]), and the object's motion after any impacts.
    #[inline]
    pub fn press(
        &self,
        strikes: &mut Strikes<S>,
        device: Motion<S>,
        object: Motion<S>,
        giving: Giving<'_, S>,
    ) -> (Motion<S>, Press<S>) {
        each!(self: Continuous | Impulsive, model => model.press(strikes, device, object, giving))
    }
}
