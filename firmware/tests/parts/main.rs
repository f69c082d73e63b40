//! The parts of the image that need no chip, from outside.

mod as5047p;
mod button;
mod ceiling;
mod contacts;
mod exchange;
mod hedge;
mod history;
mod hold;
mod kept;
mod keys;
mod mac;
mod moteus;
mod operator;
mod record;
mod recorder;
mod signals;
mod status;
mod store;
mod switch;
mod times;
