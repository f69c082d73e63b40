//! The board around the chip, as the emulator wants to know of it.

use std::num::{NonZeroU32, NonZeroU64};

use rigless::cpu::armv7m;
use rigless::machine::armv7m as core7;
use rigless::machine::{Board, Target};
use rigless::mcu::{Mcu, Operate};
use rigless::snapshot::Store;
use rigless::soc::Error;

use super::{CORE_HZ, Part};

/// The board around the chip.
#[derive(Debug)]
pub struct Nucleo {
    /// The chip with everything around it.
    pub part: Part,
}

impl Nucleo {
    /// Board 1 (strap open) or 2 (strap to ground), as it is when power comes on.
    ///
    /// # Errors
    /// What the emulator refuses.
    pub fn new(number: usize) -> Result<Self, Error> {
        let mut part = Part::new(number == 2)?;
        part.chip.rcc.attach_crystals(8_000_000, 32_768);
        part.chip.set_supply(3300);
        part.chip.set_analog_supply(3300);
        Ok(Self { part })
    }
}

impl Store for Nucleo {}

const fn register(offset: u64, reset: u32, writable: u32) -> core7::ImplementationRegister {
    core7::ImplementationRegister { offset, reset, writable }
}

impl Board for Nucleo {
    fn name(&self) -> &'static str {
        "nucleo-h743zi2"
    }
    fn target_names(&self) -> Vec<&'static str> {
        vec!["stm32h743"]
    }
    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.part)
    }
    fn targets(&mut self) -> Vec<Target<'_>> {
        let hz = NonZeroU64::new(CORE_HZ).expect("a clock");
        let core = core7::Core {
            variant: core7::Variant::M7,
            clock_hz: hz,
            interrupt_lines: NonZeroU32::new(u32::from(self.part.cpu().interrupt_lines)).expect("lines"),
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8).expect("a divider"),
            instructions_per_second: hz,
            boot: "flash",
        };
        let mut config = core7::Config::new(core, &armv7m::windows(self.part.bus()));
        config.fpu = core7::Fpu::FpV5Dp;
        config.mpu_regions = core7::MpuRegions::Sixteen;
        // Cortex-M7 r1p1 (RM0433 §60.4), 16 kB of each cache.
        config.cpuid = 0x411F_C271;
        config.caches =
            Some(core7::Caches { clidr: 0x0900_0003, ctr: 0x8303_C003, ccsidr: &[0xF00F_E019, 0xF01F_E009] });
        config.branch_prediction = core7::BranchPrediction::Always;
        // The processor's own control registers for TCM, AHB slave, error banks and cache (ARM DDI 0489).
        config.implementation_registers = vec![
            register(0xF90, 7 << 3, 7),
            register(0xF94, 8 << 3, 7),
            register(0xF98, 0, 1),
            register(0xF9C, 0, 7),
            register(0xFA0, 1 << 11, 0x7FF | 0x1F << 11),
            register(0xFA8, 0, 0),
        ];
        config.vector_table = Some(0x0800_0000);
        vec![Target::new("stm32h743", &mut self.part, config.spec())]
    }
}
