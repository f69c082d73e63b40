//! Cells and queues under every interleaving: `cargo test -p firmware --features loom --test interleavings`.

use firmware_parts::exchange::{Consumer, Latest, Queue};
use loom::thread;

/// Every interleaving of three values through a queue of two: none torn, none twice, in order, none lost but reported.
#[test]
fn a_queue_loses_only_what_it_refused() {
    loom::model(|| {
        let queue = Box::leak(Box::new(Queue::<(u32, u32), 2>::default()));
        let (mut producer, mut consumer) = queue.split();
        let putting = thread::spawn(move || {
            (1..=3).filter(|&value| producer.put(|slot| *slot = (value, 10 * value))).collect::<Vec<_>>()
        });
        let mut taken: Vec<u32> = Vec::new();
        let mut take = |consumer: &mut Consumer<'_, (u32, u32), 2>| {
            if let Some((value, tenfold)) = consumer.take() {
                assert_eq!(tenfold, 10 * value);
                taken.push(value);
            }
        };
        take(&mut consumer);
        take(&mut consumer);
        let put = putting.join().unwrap();
        for _ in 0..3 {
            take(&mut consumer);
        }
        assert_eq!(taken, put);
    });
}

/// Every interleaving of two writes with two looks: whole values only, never an older one, never the same one twice.
#[test]
fn no_interleaving_tears_or_goes_back() {
    loom::model(|| {
        let cell = Box::leak(Box::new(Latest::new((0_u32, 0_u32))));
        let (mut writer, mut reader) = cell.split();
        let writing = thread::spawn(move || {
            for value in 1..=2 {
                writer.write((value, 10 * value));
            }
        });
        let mut last = 0;
        for _ in 0..2 {
            let fresh = reader.fetch();
            let (value, tenfold) = reader.copy();
            assert_eq!(tenfold, 10 * value);
            assert_eq!(fresh, value > last, "{value} after {last}");
            last = value;
        }
        writing.join().unwrap();
        reader.fetch();
        assert_eq!(reader.copy(), (2, 20), "what was written last is what is there in the end");
    });
}
