//! Ethernet: RMII to the Nucleo's LAN8742A, descriptors and buffers in AXI SRAM, where the DMA can reach them.

use core::mem::MaybeUninit;

use embassy_executor::Spawner;
use embassy_stm32::eth::{self, Ethernet, GenericPhy, PacketQueue, Sma};
use embassy_stm32::peripherals::{ETH, ETH_SMA, PA1, PA2, PA7, PB13, PC1, PC4, PC5, PG11, PG13};
use embassy_stm32::{Peri, bind_interrupts, interrupt, pac, rcc};
use firmware_parts::mac;

use super::Number;

bind_interrupts!(struct Interrupts {
    ETH => eth::InterruptHandler;
});

/// The interrupt that is to be beneath the tick's.
pub(crate) const INTERRUPT: interrupt::Interrupt = interrupt::Interrupt::ETH;

/// The driver, as embassy-net takes it.
pub(crate) type Device = Ethernet<'static, ETH, GenericPhy<Sma<'static, ETH_SMA>>>;

/// Frames that may wait to go out and to be taken in.
type Queue = PacketQueue<8, 12>;

/// NOLOAD, and out of the DMA-less DTCM; so uninitialised until [`open`].
#[unsafe(link_section = ".axi.ethernet")]
static mut QUEUE: MaybeUninit<Queue> = MaybeUninit::uninit();

/// The Nucleo's wiring to its PHY.
pub(crate) struct Pins {
    pub(crate) eth: Peri<'static, ETH>,
    pub(crate) sma: Peri<'static, ETH_SMA>,
    pub(crate) ref_clk: Peri<'static, PA1>,
    pub(crate) mdio: Peri<'static, PA2>,
    pub(crate) crs: Peri<'static, PA7>,
    pub(crate) tx_d1: Peri<'static, PB13>,
    pub(crate) mdc: Peri<'static, PC1>,
    pub(crate) rx_d0: Peri<'static, PC4>,
    pub(crate) rx_d1: Peri<'static, PC5>,
    pub(crate) tx_en: Peri<'static, PG11>,
    pub(crate) tx_d0: Peri<'static, PG13>,
}

/// The PHY has the clock, and gives it.
pub(crate) fn clock(_: &mut rcc::Config) {}

/// A cable that may be plugged in.
pub(crate) struct Plugged(Pins, Number);

/// There is no serial port.
pub(crate) struct Serial;

/// Starts nothing: a board that talks to nobody leaves MAC and PHY alone.
pub(crate) fn plug(pins: Pins, number: Number, _: &Spawner) -> (Plugged, Serial) {
    (Plugged(pins, number), Serial)
}

/// Resets MAC and PHY and starts the link. Waits for the PHY to answer: without one it waits for ever, so call it last.
pub(crate) fn open(Plugged(pins, number): Plugged) -> Device {
    // SAFETY: `pins` exists once, so this runs once, and nothing else names QUEUE.
    let queue = unsafe {
        let place = &raw mut QUEUE;
        Queue::init(&mut *place);
        (*place).assume_init_mut()
    };
    let address = mac::address(core::array::from_fn(|word| pac::UID.uid(word).read()), number as u8 + 1);
    Ethernet::new_with_phy(
        queue,
        pins.eth,
        Interrupts,
        pins.ref_clk,
        pins.crs,
        pins.rx_d0,
        pins.rx_d1,
        pins.tx_d0,
        pins.tx_d1,
        pins.tx_en,
        address,
        GenericPhy::new(Sma::new(pins.sma, pins.mdio, pins.mdc), 0),
    )
}
