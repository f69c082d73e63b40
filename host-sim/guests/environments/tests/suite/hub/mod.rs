//! The hub: 2 to 16 peers, each behind a sealed link, hold one object.

mod address;
mod audit;
mod junction;
mod node;
mod several;
mod trial;
mod virtual_time;
