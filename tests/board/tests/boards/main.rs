//! What the release image does on virtual boards. One program, so that two tests run at a time: one alone leaves a third of two
//! cores idle, because two boards wait for each other every millisecond.
//!
//! | file | asks |
//! |---|---|
//! | [`forked`] | does a forked board do what one alone does? |
//! | [`one_board`] | does it start with its outputs off, answer, arm, stop? |
//! | [`keys`] | does it talk only to who holds the key? |
//! | [`amplifiers`] | are amplifiers commanded no current before they are enabled and after? |
//! | [`any_line`] | does it do what a line says and no more? |
//! | [`ceiling`] | are limits raised by who is at the board only? |
//! | [`calibrate`] | do cohold's calibrations find what a board's device is? |
//! | [`same_bits`], [`papers_comms`], [`current_loop`] | do two boards compute what cohold computes? |
//! | [`rig`], [`table`] | does the rig (tests/rig) find what is wrong with a board, and is the way to a table's the same? |
//! | [`second_board`] | does the other board's image do what the first's does? |
//! | [`three_axes`] | do they along three shared axes? |
//! | [`moteus`] | does a board whose motor has a controller of its own do so, and let go of it? |
//! | [`spi_encoders`] | does a board with encoders on SPI do so, and see what goes wrong with them? |
//! | [`usb`] | is a board on USB a board like any other? |
//! | [`clutch`] | does a leader's clutch change the force by no more than its share? |
//! | [`partner`] | is a board with cohold's live peer as good as with a board? |
//! | [`far`] | does it hold one object with a peer far away, by the PC beside it? |
//! | [`bad_wire`], [`cable`] | what does a bad wire do, and none? |
//! | [`faults`] (one of them an [`impostor`]), [`encoder_faults`], [`stop`], [`switch`], [`breaks`], [`deadman`], [`store`] | do outputs go off, and settings stay whole? |
//! | [`blackbox`] | does a fault leave the ticks before it, through a reset, and a line that survives power? |
//! | [`contacts`] | is a contact of the emergency stop that is bridged found? |
//! | [`update`] | does an order lead to the ROM's bootloader, safely, and start what that is given? |
//! | [`budgets`], [`static_stack`], [`times`] | do flash, memory, stack, instructions and times keep to their budgets? |

mod amplifiers;
mod any_line;
mod bad_wire;
mod blackbox;
mod breaks;
mod budgets;
mod cable;
mod calibrate;
mod ceiling;
mod clutch;
mod contacts;
mod current_loop;
mod deadman;
mod encoder_faults;
mod far;
mod faults;
mod forked;
mod impostor;
mod keys;
mod moteus;
mod one_board;
mod papers_comms;
mod partner;
mod rates;
mod recordings;
mod rig;
mod same_bits;
mod second_board;
mod spi_encoders;
mod static_stack;
mod stop;
mod store;
mod switch;
mod table;
mod three_axes;
mod times;
mod update;
mod usb;
