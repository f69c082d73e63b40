//! Every message as bytes that were written down by hand, and what version 4 refuses.

use cohold_protocol::wire::{
    Ack, Ask, AxisFlow, Bits, Error, Event, Flow, Flow2, Flow3, Goodbye, Greeting, GreetingKind, Header, MAX_MESSAGE,
    Message, Moved, Page, Part, Payload, PeerId, Presence, Probe, Push, Reply, Sample, Sighting, Stamps, TABLES,
    Telemetry, Topic,
};
use cohold_protocol::wire::{Manifest, Scope};

/// The message is these bytes, and they are the message.
fn is(message: impl Into<Message>, bytes: &[u8]) {
    let (message, mut out) = (message.into(), [0; MAX_MESSAGE]);
    assert_eq!(message.emit(&mut out), Ok(bytes.len()));
    assert_eq!(&out[..bytes.len()], bytes);
    assert_eq!(Message::parse(bytes), Ok(message));
}

/// The bytes with some of them changed are refused.
fn refused(bytes: &[u8], at: usize, with: &[u8], error: Error) {
    let mut bytes = bytes.to_vec();
    bytes[at..at + with.len()].copy_from_slice(with);
    assert_eq!(Message::parse(&bytes), Err(error), "{with:?} at {at}");
}

#[test]
fn what_links_say_for_themselves() {
    is(Ack { next: 0x0a0b_0c0d, ahead: 5 }, &[4, 0, 0, 0, 0x0d, 0x0c, 0x0b, 0x0a, 5, 0, 0, 0]);
    is(Probe { sent_us: 0x0102_0304_0506_0708 }, &[5, 0, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1]);
    let times = [1, 0, 0, 0, 0, 0, 0, 0, 3, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4];
    let reply = Reply { probe_sent_us: 1, probe_received_us: 0x0203, sent_us: 0x04 << 56 };
    is(reply, &[&[6, 0, 0, 0][..], &times].concat());
    is(Goodbye {}, &[7, 0, 0, 0]);
}

#[test]
fn flow() {
    let bytes = [
        0x01, 0x01, 0x00, 0x00, // kind, engaged
        0x78, 0x56, 0x34, 0x12, // tick
        0x00, 0x00, 0x80, 0x3f, // 1.0
        0x00, 0x00, 0x00, 0xbf, // -0.5
        0x00, 0x00, 0x20, 0x40, // 2.5
        0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xd0, 0xbf, // -0.25
        0x00, 0x00, 0x00, 0x00, 0x00, 0x40, 0x5f, 0x40, // 125.0
        0x0d, 0x0c, 0x0b, 0x0a, // live ticks
    ];
    let flow = Flow {
        engaged: true,
        fading: false,
        tick: 0x1234_5678,
        axes: [AxisFlow {
            position: 1.0,
            velocity: -0.5,
            wave: 2.5,
            wave_integral: -0.25,
            energy_sent: 125.0,
            live_ticks: 0x0a0b_0c0d,
        }],
    };
    is(flow, &bytes);
    refused(&bytes, 1, &[4], Error::Reserved("flow"));
    refused(&bytes, 3, &[1], Error::Reserved("flow"));
    refused(&bytes, 8, &f32::NAN.to_le_bytes(), Error::NotFinite("flow"));
    refused(&bytes, 28, &f64::INFINITY.to_le_bytes(), Error::NotFinite("flow"));
    // Too little room is an error.
    let wanted = Err(Error::Length { message: "flow", wanted: 40, got: 39 });
    assert_eq!(Flow::default().emit(&mut [0; 39]), wanted);
}

#[test]
fn flow_of_several_axes() {
    // Kind, fading, tick; then every axis as the one of a flow has it.
    let head = |kind| vec![kind, 2, 0, 0, 0x78, 0x56, 0x34, 0x12];
    let axis = |first| [&[0, 0, first, 0x3f][..], &[0; 24], &[first, 0, 0, 0]].concat();
    let along = |position, live_ticks| AxisFlow { position, live_ticks, ..AxisFlow::default() };
    let (one, two, three) = (along(1.0, 0x80), along(0.5, 0), along(0.5625, 0x10));
    let two_axes = [head(10), axis(0x80), axis(0)].concat();
    is(Flow2 { engaged: false, fading: true, tick: 0x1234_5678, axes: [one, two] }, &two_axes);
    let three_axes = [head(11), axis(0x80), axis(0), axis(0x10)].concat();
    is(Flow3 { engaged: false, fading: true, tick: 0x1234_5678, axes: [one, two, three] }, &three_axes);
    assert_eq!((two_axes.len(), three_axes.len()), (72, 104));
    refused(&two_axes, 1, &[4], Error::Reserved("flow of two axes"));
    refused(&three_axes, 2, &[1], Error::Reserved("flow of three axes"));
    refused(&three_axes, 72, &f32::NAN.to_le_bytes(), Error::NotFinite("flow of three axes"));
    let error = Error::Length { message: "flow of three axes", wanted: 104, got: 72 };
    refused(&two_axes, 0, &[11], error);
}

#[test]
fn telemetry() {
    let telemetry = Telemetry {
        mode: 1,
        fault: 2,
        stage: 3,
        tick: 4,
        device_position: 1.0,
        object_position: 2.0,
        desired_position: 3.0,
        contact_force: 4.0,
        coordination_force: 5.0,
        energy_received: 6.0,
        energy_sent: 7.0,
        round_trip_us: 0x10,
        jitter_us: 0x11,
        clock_offset_us: -2,
        clock_drift_ppm: -1.0,
        packets_taken: 0x12,
        packets_missing: 0x13,
        flow_late: 0x14,
        refused: 0x15,
        overruns: 0x16,
        longest_tick_ns: 0x17,
    };
    #[rustfmt::skip]
    let bytes: [u8; Telemetry::LEN] = [
        2, 1, 2, 3, 4, 0, 0, 0,
        0, 0, 0x80, 0x3f, 0, 0, 0x00, 0x40, 0, 0, 0x40, 0x40, 0, 0, 0x80, 0x40, 0, 0, 0xa0, 0x40,
        0, 0, 0, 0, 0, 0, 0x18, 0x40, 0, 0, 0, 0, 0, 0, 0x1c, 0x40,
        0x10, 0, 0, 0, 0x11, 0, 0, 0, 0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0x80, 0xbf,
        0x12, 0, 0, 0, 0x13, 0, 0, 0, 0x14, 0, 0, 0, 0x15, 0, 0, 0, 0x16, 0, 0, 0, 0x17, 0, 0, 0,
    ];
    is(telemetry, &bytes);
    let meaningless = |field| Error::OutOfRange { message: "telemetry", field };
    refused(&bytes, 1, &[184], meaningless("mode"));
    refused(&bytes, 1, &[3], meaningless("mode"));
    refused(&bytes, 3, &[6], meaningless("stage"));
}

#[test]
fn push_and_moved() {
    let push = Push { round_trip_us: 0x0102_0304, sent_us: 5, force: [1.0, -0.5], hand: [2.5, 0.0] };
    let numbers = [0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf, 0, 0, 0x20, 0x40, 0, 0, 0, 0];
    let bytes = [&[19, 0, 0, 0, 4, 3, 2, 1, 5, 0, 0, 0, 0, 0, 0, 0][..], &numbers].concat();
    is(push, &bytes);
    refused(&bytes, 2, &[1], Error::Reserved("push"));
    refused(&bytes, 16, &f32::NAN.to_le_bytes(), Error::NotFinite("push"));

    let moved = Moved { version: 9, axes: [[1.0, -0.5], [2.5, 0.0]], echo_us: 5, came_us: 6, sent_us: 0x0708 };
    let times = [5, 0, 0, 0, 0, 0, 0, 0, 6, 0, 0, 0, 0, 0, 0, 0, 8, 7, 0, 0, 0, 0, 0, 0];
    let bytes = [&[20, 0, 0, 0, 9, 0, 0, 0][..], &numbers, &times].concat();
    is(moved, &bytes);
    refused(&bytes, 1, &[1], Error::Reserved("moved"));
}

#[test]
fn events_have_up_to_48_bytes_and_samples_108() {
    let event = Event::new(0xbeef, &[9, 8, 7]).unwrap().numbered(0x0102_0304);
    is(event, &[3, 3, 0xef, 0xbe, 4, 3, 2, 1, 9, 8, 7]);
    assert_eq!(event.emitted_len(), 11);
    is(Event::new(1, &[]).unwrap(), &[3, 0, 1, 0, 0, 0, 0, 0]);
    is(Event::new(1, &[5; 48]).unwrap(), &[&[3, 48, 1, 0, 0, 0, 0, 0][..], &[5; 48]].concat());
    assert_eq!(Event::new(1, &[5; 49]), Err(Error::Length { message: "event payload", wanted: 48, got: 49 }));
    refused(&[3; 57], 1, &[49], Error::OutOfRange { message: "event", field: "payload length" });
    refused(&[3], 0, &[3], Error::Length { message: "event", wanted: 8, got: 1 });

    is(Sample::new(0x1234, &[0xaa, 0xbb]).unwrap(), &[9, 2, 0x34, 0x12, 0xaa, 0xbb]);
    is(Sample::new(1, &[7; 108]).unwrap(), &[&[9, 108, 1, 0][..], &[7; 108]].concat());
    assert!(Sample::new(0, &[0; 109]).is_err());
    refused(&[9, 1, 0, 0], 0, &[], Error::Length { message: "sample", wanted: 5, got: 4 });
    refused(&[9, 0, 0, 0, 0], 0, &[], Error::Length { message: "sample", wanted: 4, got: 5 });
    refused(&[9, 109, 0, 0], 0, &[], Error::OutOfRange { message: "sample", field: "payload length" });
}

#[test]
fn presence_has_up_to_4_sightings() {
    let sighting = Sighting { who: 300, position: [1.0, -0.5], velocity: [2.5, 0.0] };
    let seen = [0x2c, 1, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf, 0, 0, 0x20, 0x40, 0, 0, 0, 0];
    is(Presence::new(0x0102_0304, [sighting]), &[&[18, 1, 0, 0, 4, 3, 2, 1][..], &seen].concat());
    assert_eq!(Presence::new(0, [sighting; 9]).seen(), [sighting; 4]);
    refused(&[18; 108], 1, &[5], Error::OutOfRange { message: "presence", field: "count" });
}

#[test]
fn ask() {
    let mut wanted = Bits::default();
    [0, 9, 255].into_iter().for_each(|bit| wanted.set(bit));
    let scope = Scope::Around { x: 1.0, y: -0.5, radius: 2.5 };
    let ask = Ask { topic: Topic::Object, first: 0x0100, scope, tag: 7, wanted };
    let mut bytes = [0; Ask::LEN];
    bytes[..8].copy_from_slice(&[16, 3, 0, 1, 1, 0, 7, 0]);
    bytes[8..20].copy_from_slice(&[0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf, 0, 0, 0x20, 0x40]);
    (bytes[20], bytes[21], bytes[51]) = (1, 2, 0x80);
    is(ask, &bytes);
    assert!(ask.numbers().eq([256, 265, 511]));
}

#[test]
fn a_scope_has_what_belongs_to_it_and_nothing_else() {
    let error = Error::OutOfRange { message: "ask", field: "scope" };
    let mut bytes = [0; Ask::LEN];
    bytes[0] = Ask::KIND;
    is(Ask::default(), &bytes);
    refused(&bytes, 4, &[0, 9], error);
    refused(&bytes, 4, &[3, 9], error);
    bytes[4..6].copy_from_slice(&[2, 9]);
    is(Ask { scope: Scope::Region(9), ..Ask::default() }, &bytes);
    bytes[4..6].copy_from_slice(&[1, 0]);
    refused(&bytes, 19, &[0xbf], error); // a radius below 0
}

#[test]
fn part() {
    let manifest = Manifest { version: 3, objects: 0x0201, regions: 2, margin_m: 0.5 };
    let part = Part { number: 0, tag: 9, world: 0x0807_0605_0403_0201, payload: Payload::Manifest(manifest) };
    let head = [17, 0, 0, 0, 9, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8];
    is(part, &[&head[..], &[3, 0, 0, 0, 1, 2, 2, 0, 0, 0, 0, 0x3f]].concat());

    let mut page = Page { mask: 0b101, ..Page::default() };
    (page.checksums[0], page.checksums[2]) = (1, 0x0203);
    let mut bytes = [0; Part::MAX_LEN];
    bytes[..3].copy_from_slice(&[17, 2, 5]);
    bytes[16..21].copy_from_slice(&[5, 0, 0, 0, 1]);
    bytes[36..38].copy_from_slice(&[3, 2]);
    is(Part { number: 5, tag: 0, world: 0, payload: Payload::Page(page) }, &bytes);
    // A checksum of an object that is not in scope.
    refused(&bytes, 28, &[1], Error::Reserved("part"));

    let mut bytes = [0; Part::HEAD + Part::OBJECT_LEN];
    bytes[..2].copy_from_slice(&[Part::KIND, 3]);
    assert!(Part::parse(&bytes).is_ok());
    refused(&bytes[..79], 0, &[], Error::Length { message: "part", wanted: 80, got: 79 });
    refused(&bytes, 1, &[4], Error::OutOfRange { message: "part", field: "topic" });
}

#[test]
fn header() {
    let bytes = [4, 3, 7, 9, 0xdd, 0xcc, 0xbb, 0xaa, 8, 7, 6, 5, 4, 3, 2, 1];
    let header = Header { from: PeerId(7), to: PeerId(9), session: 0xaabb_ccdd, sequence: 0x0102_0304_0506_0708 };
    let mut out = [0; Header::LEN];
    assert_eq!(header.emit(&mut out), Ok(Header::LEN));
    assert_eq!(out, bytes);
    let mut datagram = [0x55; 33];
    datagram[..16].copy_from_slice(&bytes);
    assert_eq!(Header::parse(&mut datagram), Ok((header, &bytes, &mut [0x55; 17][..])));
    for version in [0, 1, 3, 255] {
        datagram[0] = version;
        assert_eq!(Header::parse(&mut datagram), Err(Error::UnknownVersion(version)));
    }
    assert_eq!(Error::UnknownVersion(1).to_string(), "version 1 is spoken here, this end speaks 4");
    datagram[..2].copy_from_slice(&[4, 4]);
    assert_eq!(Header::parse(&mut datagram), Err(Error::UnknownKind(4)));
    let error = Error::Length { message: "sealed", wanted: 32, got: 31 };
    assert_eq!(Header::parse(&mut datagram[..31]), Err(error));
}

#[test]
fn stamps() {
    let mut out = [0; Stamps::LEN];
    for (padding, lease) in [(0, 0), (44, 1), (0, 0x80), (127, 0xFF)] {
        let stamps = Stamps { sealed_us: 0x02_0304_0506_0708, padding, echo_us: 9, lease };
        assert_eq!(stamps.emit(&mut out), Ok(Stamps::LEN));
        assert_eq!(out, [8, 7, 6, 5, 4, 3, 2, padding, 9, 0, 0, 0, 0, 0, 0, lease]);
        assert_eq!(Stamps::parse(&out), Ok(stamps));
    }
    assert!(Stamps::parse(&out[1..]).is_err());
    out[7] = 128;
    assert_eq!(Stamps::parse(&out), Err(Error::Reserved("stamps")));
}

#[test]
fn greeting() {
    let mut tables = [[0; 6]; TABLES];
    (tables[0], tables[1]) = ([8, 7, 6, 5, 4, 3], [0xff; 6]);
    let greeting = Greeting {
        kind: GreetingKind::Welcome,
        from: PeerId(1),
        to: PeerId(2),
        line: 0x0403_0201,
        challenge: [0xaa; 16],
        echo: [0xbb; 16],
        incarnation: 0x1122_3344_5566_7788,
        ephemeral: [0xcc; 32],
        count: 2,
        tables,
    };
    let mut bytes = [0; Greeting::TAGGED];
    bytes[..8].copy_from_slice(&[4, 2, 1, 2, 1, 2, 3, 4]);
    bytes[8..24].fill(0xaa);
    bytes[24..40].fill(0xbb);
    bytes[40..48].copy_from_slice(&[0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11]);
    bytes[48..80].fill(0xcc);
    bytes[80] = 2;
    bytes[88..94].copy_from_slice(&[8, 7, 6, 5, 4, 3]);
    bytes[94..100].fill(0xff);
    let mut out = [0; Greeting::TAGGED];
    assert_eq!(greeting.emit(&mut out), Ok(Greeting::LEN));
    assert_eq!(out, bytes);
    bytes[184..].fill(0x77);
    assert_eq!(Greeting::parse(&bytes), Ok((greeting, &bytes[..184], &[0x77; 16])));
    // More tables than there is room for, and one that is not counted.
    bytes[80] = 17;
    assert_eq!(Greeting::parse(&bytes), Err(Error::OutOfRange { message: "greeting", field: "count" }));
    bytes[80] = 1;
    assert_eq!(Greeting::parse(&bytes), Err(Error::Reserved("greeting")));
}
