//! What core computes, against closed forms, brute force and code that shares nothing with it. One program: fifteen would each link it.
//!
//! | file | asks |
//! |---|---|
//! | [`fixed`], [`sin_cos`] | does arithmetic round and saturate as it says? |
//! | [`total`] | is every tick of every scene defined, and within its limits? |
//! | [`bounds`] | does what another end may say follow from the limits? |
//! | [`law`], [`copies`] | does every law keep its promise? |
//! | [`object`], [`free_body`], [`rigid`], [`plane`], [`contact`] | do bodies move and touch as mechanics says? |
//! | [`device`], [`probe`], [`winding`] | does a device read, drive, and find out what is wrong with it? |
//! | [`peer`] | does a peer start, stop, and hold its forces? |

mod bounds;
mod contact;
mod copies;
mod device;
mod fixed;
mod free_body;
mod law;
mod object;
mod peer;
mod plane;
mod playout;
mod probe;
mod rigid;
mod sin_cos;
mod total;
mod two_copies;
mod winding;

// What every law is asked, cohold-laws asks of its own with the same files.
use cohold_core::law::AnyLaw;

const SCHEMA: cohold_core::schema::Schema = cohold_core::schema::Schema::BUILT_IN;

/// Laws whose waves or sums are bounded.
const BOUNDED: &[&str] = &["wave", "passive-wave", "passive-mean", "self-timed"];
