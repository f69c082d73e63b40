//! The store on a flash made of memory: every instant at which power may go.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use cohold_core::settings::{Allowed, Settings, Value};
use firmware_parts::kept::Kept;
use firmware_parts::store::{Broken, Medium, SECTOR, Store, Unreadable, Word};

/// Words in a slot, and bytes in a word.
const SLOT: u32 = 256;
const BYTES: usize = 32;

/// Flash in memory. A word is blank, programmed or lost; programming what is not blank is a fault of the program.
#[derive(Clone)]
struct Memory {
    words: Vec<Option<Word>>,
    erases: u32,
    /// Steps until power goes.
    left: u32,
    /// What a step that power caught half-way leaves.
    half: Option<fn(&Word) -> Option<Word>>,
    /// Words that do not take what they are given.
    bad: Vec<u32>,
}

impl Memory {
    fn new() -> Self {
        // Never erased in this life: what it holds means nothing.
        Self { words: vec![Some([0x5A; 32]); 2 * SECTOR as usize], erases: 0, left: u32::MAX, half: None, bad: vec![] }
    }

    /// Whether the step is the one that power goes at, or comes after.
    fn cut(&mut self) -> Option<bool> {
        let now = self.left == 0;
        let after = self.left == u32::MAX - 1;
        self.left = if now { u32::MAX - 1 } else { self.left - u32::from(self.left < u32::MAX - 1) };
        (now || after).then_some(now)
    }
}

impl Medium for Memory {
    fn read(&self, at: u32) -> Option<Word> {
        self.words[at as usize]
    }
    fn program(&mut self, at: u32, word: &Word) -> Result<(), Broken> {
        match self.cut() {
            None => {
                assert_eq!(self.words[at as usize], Some([0xFF; 32]), "word {at} is programmed but not blank");
                self.words[at as usize] = if self.bad.contains(&at) { None } else { Some(*word) };
                Ok(())
            }
            Some(now) => {
                if let (true, Some(half)) = (now, self.half) {
                    self.words[at as usize] = half(word);
                }
                Err(Broken)
            }
        }
    }
    async fn erase(&mut self, sector: u32) -> Result<(), Broken> {
        let range = (sector * SECTOR) as usize..((sector + 1) * SECTOR) as usize;
        match self.cut() {
            None => {
                self.words[range].fill(Some([0xFF; 32]));
                self.erases += 1;
                Ok(())
            }
            Some(now) => {
                // Some of it is blank, some lost, some as it was.
                if now && self.half.is_some() {
                    for (at, word) in self.words[range].iter_mut().enumerate() {
                        match at % 3 {
                            0 => *word = Some([0xFF; 32]),
                            1 => *word = None,
                            _ => {}
                        }
                    }
                }
                Err(Broken)
            }
        }
    }
}

fn done<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => panic!("flash in memory does not wait"),
    }
}

fn numbered(n: u32) -> Kept {
    let mut kept = Kept::default();
    kept.set("object.mass_kg", Value::Number(0.1 + f64::from(n) / 3000.0)).unwrap();
    kept.set("network.peer", Value::Text("10.0.0.9")).unwrap();
    kept
}

fn loaded(memory: &Memory) -> Option<Kept> {
    Store::open(memory).load(memory).map(|kept| kept.expect("a sound record is readable"))
}

#[test]
fn a_cut_at_any_step_leaves_the_old_or_the_new() {
    type Half = fn(&Word) -> Option<Word>;
    let halves: [Option<Half>; 4] = [
        None,
        Some(|_| None),
        // Some bits are programmed, others not yet.
        Some(|word| Some(word.map(|byte| byte | 0x0F))),
        Some(|word| Some(core::array::from_fn(|at| if at < 20 { word[at] } else { 0xFF }))),
    ];
    // The 16th save into a sector, and the next, which erases the other one.
    let mut memory = Memory::new();
    let mut store = Store::open(&memory);
    for n in 1..=15 {
        assert_eq!(done(store.save(&mut memory, &numbered(n))), Ok(n));
    }
    let mut tried = 0;
    for n in 16..=18 {
        for half in halves {
            let mut steps = 0;
            loop {
                let mut cut = Memory { left: steps, half, ..memory.clone() };
                let saved = done(store.clone().save(&mut cut, &numbered(n)));
                cut = Memory { left: u32::MAX, ..cut };
                let now = loaded(&cut);
                if saved.is_ok() {
                    assert_eq!(now, Some(numbered(n)));
                    break;
                }
                assert!(now == Some(numbered(n - 1)) || now == Some(numbered(n)), "save {n}, step {steps}");
                // And the next start saves on, whatever is left.
                let mut after = Store::open(&cut);
                assert!(done(after.save(&mut cut, &numbered(99))).is_ok(), "save {n}, step {steps}: then not");
                assert_eq!(loaded(&cut), Some(numbered(99)));
                steps += 1;
                tried += 1;
            }
            assert!(steps > 40, "a save is {steps} steps");
        }
        assert_eq!(done(store.save(&mut memory, &numbered(n))), Ok(n));
    }
    assert_eq!(memory.erases, 2);
    assert!(tried > 500, "{tried} cuts");
}

#[test]
fn a_word_that_does_not_take_is_passed_over() {
    let mut memory = Memory::new();
    let mut store = Store::open(&memory);
    assert_eq!(done(store.save(&mut memory, &numbered(1))), Ok(1));
    memory.bad = vec![SLOT + 3];
    assert_eq!(done(store.save(&mut memory, &numbered(2))), Ok(2));
    assert_eq!(loaded(&memory), Some(numbered(2)));
    assert_eq!(Store::open(&memory), store);
    memory.bad = (3 * SLOT..2 * SECTOR).collect();
    assert_eq!(done(store.save(&mut memory, &numbered(3))), Err(Broken));
    assert_eq!(loaded(&memory), Some(numbered(2)), "what was saved before stands");
}

#[test]
fn an_image_with_other_keys_reads_a_record_for_what_it_says() {
    let write = |text: &str| -> Result<Kept, Unreadable> {
        let mut memory = Memory::new();
        memory.words[..SECTOR as usize].fill(Some([0xFF; 32]));
        let padded = [text.as_bytes(), &[0; BYTES]].concat();
        for (nth, bytes) in (1..).zip(padded.as_chunks().0) {
            memory.program(nth, bytes).unwrap();
        }
        memory.program(0, &header(1, text)).unwrap();
        Store::open(&memory).load(&memory).expect("a record")
    };
    // In another order, with keys missing.
    let kept = write("object.mass_kg 0.5\nnetwork.dhcp true\ncoordination.comm power\n").unwrap();
    assert_eq!((kept.settings.object.mass_kg, kept.addresses.dhcp), (0.5, true));
    assert_eq!(kept.settings.contact, Settings::default().contact);
    // A key that is gone, a value that is not allowed any more, a line that is none: all of it, not a part.
    for line in ["object.colour red", "object.mass_kg -1", "object.mass_kg red", "nothing"] {
        let unreadable = write(&format!("safety.max_force_n 1\n{line}\n")).unwrap_err();
        assert_eq!((unreadable.line.as_str(), unreadable.hold_switch), (line, false));
        // A hold-to-run switch that was there is not forgotten.
        assert!(write(&format!("board.hold_switch true\n{line}\n")).unwrap_err().hold_switch);
    }
    assert_eq!(Kept::keys().next(), Some("board.hold_switch"), "first of all lines");
    let long = "x".repeat(200);
    assert!(write(&format!("{long}\n")).is_err());
}

#[test]
fn everything_fits_at_its_longest() {
    let longest: usize = (Settings::keys())
        .map(|key| {
            let names = match key.allowed {
                Allowed::Names(names) => names.iter().map(|name| name.len()).max().unwrap(),
                // A double is at most 24 characters here: -1.2345678901234567e-308 is never that small or large.
                _ => 24,
            };
            key.name.len() + 1 + names + 1
        })
        .chain(
            [
                "board.hold_switch false",
                "network.dhcp false",
                "network.address 255.255.255.255",
                "network.gateway ",
                "network.peer ",
            ]
            .map(str::len),
        )
        .sum();
    let room = (SLOT as usize - 1) * BYTES;
    assert!(longest + 40 < room, "{longest} of {room} bytes");
    // Longest line: 96 bytes.
    assert!(Kept::keys().all(|key| key.len() + 26 < 96));
}

#[test]
fn the_sum_is_zips() {
    assert_eq!(crc(b"123456789"), 0xCBF4_3926);
    let mut memory = Memory::new();
    done(Store::open(&memory).save(&mut memory, &numbered(1))).unwrap();
    let text: String = Kept::keys().map(|key| format!("{key} {}\n", numbered(1).get(key).unwrap())).collect();
    assert_eq!(memory.words[0], Some(header(1, &text)));
}

/// Word 0 of a record, as the table at the top of the store has it.
fn header(generation: u32, text: &str) -> Word {
    let fields = [0x5370_6148, 1, generation, text.len() as u32].map(u32::to_le_bytes).concat();
    let sum = crc(&[text.as_bytes(), &fields].concat()).to_le_bytes();
    [&fields[..], &sum, &[0; 12]].concat().try_into().unwrap()
}

/// CRC-32 (ISO-HDLC), bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for bit in bytes.iter().flat_map(|byte| (0..8).map(move |at| byte >> at & 1)) {
        crc = crc >> 1 ^ if (crc ^ u32::from(bit)) & 1 == 1 { 0xEDB8_8320 } else { 0 };
    }
    !crc
}
