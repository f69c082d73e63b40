//! Telemetry: what the ticks did, to whoever asked for it: a decimated stream, or so many ticks in a row.
//!
//! A datagram holds up to 16 records ([`firmware_parts::record`]), oldest first, after 8 bytes: `HT`, version 1, the
//! number of records, and how many were lost so far (u32, little-endian). It goes back to the endpoint that sent
//! `stream` or `capture`. Events go to defmt, from tasks only.

use core::cell::Cell;
use core::sync::atomic::Ordering;

use embassy_net::udp::{PacketMetadata, UdpSocket};
use embassy_net::{IpEndpoint, Stack};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::{Duration, Ticker};
use firmware_parts::exchange::Consumer;
use firmware_parts::record::{self, Record};
use static_cell::ConstStaticCell;

use crate::net;
use crate::tick::{RECORD_EVERY, RECORDS, RECORDS_LOST};

/// Port that telemetry comes from.
const PORT: u16 = 7703;
/// Records in a datagram.
const BATCH: usize = 16;
const HEADER: usize = 8;

/// Who listens, and to how many records yet (`None`: until told otherwise).
#[derive(Clone, Copy)]
struct Listener {
    endpoint: IpEndpoint,
    left: Option<u32>,
}

static LISTENER: Mutex<CriticalSectionRawMutex, Cell<Option<Listener>>> = Mutex::new(Cell::new(None));

/// Every `every`-th tick to `endpoint` from now on; 0 ends it.
pub(crate) fn stream(endpoint: IpEndpoint, every: u32) {
    LISTENER.lock(|listener| listener.set((every > 0).then_some(Listener { endpoint, left: None })));
    RECORD_EVERY.store(every, Ordering::Relaxed);
}

/// The next `ticks` ticks to `endpoint`, every one.
pub(crate) fn capture(endpoint: IpEndpoint, ticks: u32) {
    LISTENER.lock(|listener| listener.set((ticks > 0).then_some(Listener { endpoint, left: Some(ticks) })));
    RECORD_EVERY.store(u32::from(ticks > 0), Ordering::Relaxed);
}

/// Sends what there is, every 4 ms.
#[embassy_executor::task]
pub(crate) async fn run(stack: Stack<'static>, mut records: Consumer<'static, Record, RECORDS>) -> ! {
    static TX_META: ConstStaticCell<[PacketMetadata; 8]> = ConstStaticCell::new([PacketMetadata::EMPTY; 8]);
    static TX: ConstStaticCell<[u8; 6144]> = ConstStaticCell::new([0; 6144]);
    static DATAGRAM: ConstStaticCell<[u8; HEADER + BATCH * record::BYTES]> =
        ConstStaticCell::new([0; HEADER + BATCH * record::BYTES]);
    let datagram = DATAGRAM.take();
    let mut sender = net::Sender::new(UdpSocket::new(stack, &mut [], &mut [], TX_META.take(), TX.take()), PORT);
    let mut pace = Ticker::every(Duration::from_millis(4));
    loop {
        pace.next().await;
        sender.tend();
        while let Some(listener) = LISTENER.lock(Cell::get) {
            let batch = listener.left.map_or(BATCH, |left| BATCH.min(left as usize));
            let (header, body) = datagram.split_at_mut(HEADER);
            let mut filled = 0;
            for (slot, _) in body.chunks_exact_mut(record::BYTES).zip(0..batch) {
                let Some(record) = records.take() else { break };
                slot.copy_from_slice(&record.bytes());
                filled += 1;
            }
            if filled == 0 {
                break;
            }
            header.copy_from_slice(&[b'H', b'T', 1, filled as u8, 0, 0, 0, 0]);
            header[4..].copy_from_slice(&RECORDS_LOST.load(Ordering::Relaxed).to_le_bytes());
            sender.send(&datagram[..HEADER + filled * record::BYTES], listener.endpoint).await;
            if let Some(left) = listener.left {
                let left = left - filled as u32;
                if left == 0 {
                    stream(listener.endpoint, 0);
                } else {
                    LISTENER.lock(|cell| cell.set(Some(Listener { left: Some(left), ..listener })));
                }
            }
            if filled < batch {
                break;
            }
        }
        if RECORD_EVERY.load(Ordering::Relaxed) == 0 {
            while records.take().is_some() {}
        }
    }
}
