//! Cells and queues as one thread sees them; their interleavings are loom's (src/exchange.rs).

use firmware_parts::exchange::{Latest, Queue};

#[test]
fn a_queue_keeps_order_and_says_when_it_is_full() {
    let mut queue = Queue::<u32, 4>::default();
    let (mut producer, mut consumer) = queue.split();
    for round in 0..5 {
        for value in 0..4 {
            assert!(producer.put(|slot| *slot = 10 * round + value));
        }
        assert!(!producer.put(|slot| *slot = 99));
        for value in 0..4 {
            assert_eq!(consumer.take(), Some(10 * round + value));
        }
        assert_eq!(consumer.take(), None);
    }
}

#[test]
fn the_newest_value_is_taken_once() {
    let mut cell = Latest::new(0);
    let (mut writer, mut reader) = cell.split();
    assert_eq!((reader.take(), *reader.get()), (None, 0));
    writer.write(1);
    writer.write(2);
    assert_eq!(reader.take(), Some(2));
    assert_eq!((reader.take(), *reader.get()), (None, 2));
    writer.write(3);
    assert_eq!(reader.take(), Some(3));
}

#[test]
fn what_is_filled_in_place_is_published_only_if_it_is_said_so() {
    let mut cell = Latest::new([0; 2]);
    let (mut writer, mut reader) = cell.split();
    let mut fill = |value: i32, publish: bool| {
        writer.fill(|slot| {
            *slot = [value; 2];
            publish
        });
    };
    fill(1, false);
    assert_eq!(reader.take(), None);
    fill(2, true);
    fill(3, false);
    assert_eq!((reader.take(), reader.take()), (Some([2; 2]), None));
}

#[test]
fn what_the_reader_holds_stands_while_the_writer_goes_on() {
    let mut cell = Latest::new([0; 2]);
    let (mut writer, mut reader) = cell.split();
    writer.write([1; 2]);
    reader.fetch();
    let held = *reader.get();
    for value in 2..9 {
        writer.write([value; 2]);
        assert_eq!(*reader.get(), held);
    }
}
