//! The board's own USB (CN13) in place of Ethernet: a network card of class NCM, and a serial port.
//!
//! The chip's second core for USB, at full speed on PA11 and PA12. Its 48 MHz are PLL3's, from the external clock: a board whose clock is
//! missing is up to 1 % off, and a PC may not understand it. PA9 sees the PC's 5 V: they are gone when the cable is, and the link is down as
//! it is with Ethernet. Buffers lie where the processor alone reaches: this core has FIFOs of its own and no DMA is used.
//!
//! The PC's end of the network has an address (MAC) of its own, which is the board's but for a bit.
//!
//! **Limits**: one frame in a transfer. The class copies a frame as long as a PC says it is, so there is room for the longest that its block holds; what is
//! mis-shaped it refuses. A PC that halts an endpoint which the chip does not have resets the board, as a wrong state does (motors off). A
//! PC that sleeps without taking its 5 V away is a peer that is silent.

use embassy_executor::Spawner;
use embassy_stm32::peripherals::{PA9, PA11, PA12, USB_OTG_FS};
use embassy_stm32::rcc::{self, PllDiv, PllMul, mux::Usbsel};
use embassy_stm32::usb::{self, Driver};
use embassy_stm32::{Peri, bind_interrupts, interrupt, pac};
use embassy_usb::class::cdc_acm::{self, CdcAcmClass};
use embassy_usb::class::cdc_ncm::embassy_net::{self, Runner};
use embassy_usb::class::cdc_ncm::{self, CdcNcmClass};
use embassy_usb::{Builder, UsbDevice};
use firmware_parts::mac;
use static_cell::{ConstStaticCell, StaticCell};

use super::Number;

bind_interrupts!(struct Interrupts {
    OTG_FS => usb::InterruptHandler<USB_OTG_FS>;
});

/// The interrupt that is to be beneath the tick's.
pub(crate) const INTERRUPT: interrupt::Interrupt = interrupt::Interrupt::OTG_FS;

/// Room for a frame, bytes: the class' whole block. Ethernet's are 1514 at the most, and what the board says fits (`sockets`).
const FRAME: usize = 2048;
/// Bytes of a packet at full speed.
const PACKET: u16 = 64;
/// The bit by which the addresses of a board and of its PC differ.
const PC: u8 = 1 << 2;
/// A pair that pid.codes keeps for tests: nobody's product.
const VENDOR: u16 = 0x1209;
const PRODUCT: u16 = 0x0001;

/// The network card, as embassy-net takes it.
pub(crate) type Device = embassy_net::Device<'static, FRAME>;
type Core = Driver<'static, USB_OTG_FS>;
/// The serial port.
pub(crate) type Serial = CdcAcmClass<'static, Core>;

/// The Nucleo's wiring to its second connector.
pub(crate) struct Pins {
    pub(crate) core: Peri<'static, USB_OTG_FS>,
    pub(crate) plus: Peri<'static, PA12>,
    pub(crate) minus: Peri<'static, PA11>,
    /// Looked at by the core, where it is left as a reset leaves it.
    pub(crate) supply: Peri<'static, PA9>,
}

/// 48 MHz: 4 · 96 / 8, from what the first PLL has.
pub(crate) fn clock(rcc: &mut rcc::Config) {
    rcc.pll3 = rcc.pll1.map(|pll| rcc::Pll { mul: PllMul::MUL96, divp: None, divq: Some(PllDiv::DIV8), ..pll });
    rcc.mux.usbsel = Usbsel::PLL3_Q;
}

/// A cable that may be plugged in: the network card.
pub(crate) struct Plugged(Device);

/// Starts what a PC sees, and gives the serial port for who speaks there.
pub(crate) fn plug(pins: Pins, number: Number, spawner: &Spawner) -> (Plugged, Serial) {
    static OUT: ConstStaticCell<[u8; 4 * PACKET as usize]> = ConstStaticCell::new([0; _]);
    static DESCRIPTORS: ConstStaticCell<[[u8; 256]; 4]> = ConstStaticCell::new([[0; _]; _]);
    static NETWORK: StaticCell<cdc_ncm::State<'static>> = StaticCell::new();
    static FRAMES: ConstStaticCell<embassy_net::State<FRAME, 2, 2>> = ConstStaticCell::new(embassy_net::State::new());
    static SERIAL: StaticCell<cdc_acm::State<'static>> = StaticCell::new();

    let mut config = usb::Config::default();
    config.vbus_detection = true;
    let core = Driver::new_fs(pins.core, Interrupts, pins.plus, pins.minus, OUT.take(), config);
    // Nothing drives it, and nothing but the core listens.
    let _ = pins.supply;

    let mut config = embassy_usb::Config::new(VENDOR, PRODUCT);
    config.manufacturer = Some("Networked haptics");
    config.product = Some(match number {
        Number::One => "Haptic board 1",
        Number::Two => "Haptic board 2",
    });
    config.self_powered = true;
    config.max_power = 0;
    let [configuration, capabilities, microsoft, control] = DESCRIPTORS.take();
    let mut builder = Builder::new(core, config, configuration, capabilities, microsoft, control);
    let own = mac::address(core::array::from_fn(|word| pac::UID.uid(word).read()), number as u8 + 1);
    let [first, rest @ ..] = own;
    let [a, b, c, d, e] = rest;
    let network = NETWORK.init_with(cdc_ncm::State::new);
    let network = CdcNcmClass::new(&mut builder, network, [first ^ PC, a, b, c, d, e], PACKET);
    let serial = CdcAcmClass::new(&mut builder, SERIAL.init_with(cdc_acm::State::new), PACKET);
    let (runner, device) = network.into_embassy_net_device(FRAMES.take(), own);
    spawner.spawn(defmt::unwrap!(run(builder.build())));
    spawner.spawn(defmt::unwrap!(carry(runner)));
    (Plugged(device), serial)
}

/// The network card, for who has something to say.
pub(crate) fn open(Plugged(device): Plugged) -> Device {
    device
}

/// Answers the PC's questions about what this is, for ever.
#[embassy_executor::task]
async fn run(mut device: UsbDevice<'static, Core>) -> ! {
    device.run().await
}

/// Carries frames, for ever.
#[embassy_executor::task]
async fn carry(runner: Runner<'static, Core, FRAME>) -> ! {
    runner.run().await
}
