//! The parts of the image that need no chip, from outside.

mod exchange;
mod hedge;
mod hold;
mod kept;
mod operator;
mod record;
mod signals;
mod status;
mod store;
