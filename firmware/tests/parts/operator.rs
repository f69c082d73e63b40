//! The operator's lines: what is read, and what is none.

use cohold_core::device::probe::{self, Shape};
use cohold_core::settings::Value;
use firmware_parts::operator::{Misread, Request, Time, Whose, parse};
use firmware_parts::record;

#[test]
fn lines_are_read_as_written() {
    assert_eq!(parse("arm\n"), Ok(Request::Arm { alone: false }));
    assert_eq!(parse("arm alone"), Ok(Request::Arm { alone: true }));
    assert_eq!(parse("clear"), Ok(Request::Clear));
    assert_eq!((parse("home"), parse("home 1")), (Ok(Request::Home), Err(Misread::Arguments)));
    assert_eq!(
        (parse("clutch"), parse("release"), parse("clutch 1")),
        (Ok(Request::Clutch), Ok(Request::Release), Err(Misread::Arguments))
    );
    assert_eq!((parse("update"), parse("update now")), (Ok(Request::Update), Err(Misread::Arguments)));
    assert_eq!(parse(" status "), Ok(Request::Status));
    assert_eq!(parse("set coordination.comm wave\r\n"), Ok(Request::Set("coordination.comm", Value::Text("wave"))));
    assert_eq!(parse("set object.mass_kg 0.3"), Ok(Request::Set("object.mass_kg", Value::Number(0.3))));
    assert_eq!(parse("set contact.one_sided true"), Ok(Request::Set("contact.one_sided", Value::Flag(true))));
    assert_eq!(parse("stream off"), Ok(Request::Stream(0)));
    assert_eq!(parse("capture 500"), Ok(Request::Capture { ticks: 500, at: 0 }));
    assert_eq!(parse("capture 9 at parted"), Ok(Request::Capture { ticks: 9, at: record::PARTED }));
    assert_eq!((parse("blackbox"), parse("history")), (Ok(Request::Blackbox), Ok(Request::History)));
    assert_eq!(parse("time spacing"), Ok(Request::Time(Whose::Tick, Time::Spacing)));
    assert_eq!(parse("time loop delay"), Ok(Request::Time(Whose::CurrentLoop, Time::Delay)));
    assert_eq!(parse("time load"), Ok(Request::Load));
    assert_eq!([parse("time"), parse("time loop"), parse("time loop load")], [Err(Misread::Arguments); 3]);
    assert_eq!(parse("check 2"), Ok(Request::Check(2)));
    let sine = probe::Request { joint: 1, shape: Shape::Sine, duty: -0.05, duration_s: 2.0, frequency_hz: 7.5 };
    assert_eq!(parse("probe 1 sine -0.05 2 7.5"), Ok(Request::Probe(sine)));
    let pulse = probe::Request { shape: Shape::Pulse, frequency_hz: 0.0, ..sine };
    assert_eq!(parse("probe 1 pulse -0.05 2"), Ok(Request::Probe(pulse)));
}

#[test]
fn what_is_no_line_says_why() {
    assert_eq!(parse(""), Err(Misread::Empty));
    assert_eq!(parse("launch"), Err(Misread::Word));
    assert_eq!(parse("set a"), Err(Misread::Arguments));
    assert_eq!(parse("stream x"), Err(Misread::Arguments));
    for line in [
        "probe",
        "probe 1 push 0.1 1",
        "probe 1 sine 0.1",
        "probe 1 sine 0.1 1 5 9",
        "check",
        "check one",
        "time",
        "time all",
    ] {
        assert_eq!(parse(line), Err(Misread::Arguments), "{line}");
    }
}

#[test]
fn stopping_is_never_misread_for_what_follows_it() {
    assert_eq!(parse("disarm!"), Err(Misread::Word));
    assert_eq!(parse("disarm now please"), Ok(Request::Disarm));
}

#[test]
fn arming_takes_one_word_at_the_most() {
    assert_eq!(parse("arm alone please"), Err(Misread::Arguments));
    assert_eq!(parse("arm everything"), Err(Misread::Arguments));
}
