//! Errata of the STM32G474 (ES0430) that were considered for this board, and its silicon revisions.
//!
//! Sections are numbered as in revision 9 of ES0430 (June 2024). The sheet itself was not
//! available. Each row names the public source from which its content is known.

/// Treatment of an erratum on this board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handling {
    /// The condition of the erratum does not occur here.
    NotMet(&'static str),
    /// The workaround is in the code.
    Handled {
        /// The workaround.
        how: &'static str,
        /// File of a test in the repository, and a text of that test; `None` if only reviewed.
        test: Option<(&'static str, &'static str)>,
    },
    /// The amplifier stays off on the affected revisions.
    Refused(&'static str),
    /// The condition occurs, and is not fully avoided.
    Open(&'static str),
    /// The text of the section could not be read.
    Unread,
}

/// Erratum of the microcontroller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Erratum {
    /// Section, or sections, of ES0430.
    pub sections: &'static str,
    /// Limitation, in our words.
    pub limitation: &'static str,
    /// Treatment on this board.
    pub handling: Handling,
    /// Source of the limitation.
    pub source: &'static str,
}

/// Silicon revisions, DBGMCU_IDCODE.REV_ID, and the letters on their packages.
const REVISIONS: [(u16, char); 3] = [(REVISION_Z, 'Z'), (0x2002, 'Y'), (0x2003, 'X')];
/// Revision Z: conversions of several ADCs disturb each other (2.7.7, 2.7.8).
const REVISION_Z: u16 = 0x2001;

/// Returns the letter of a silicon revision; `None` for an unknown one.
pub fn letter(revision: u16) -> Option<char> {
    REVISIONS.into_iter().find(|(known, _)| *known == revision).map(|(_, letter)| letter)
}

/// Returns `true` for a revision with an erratum that is not handled.
pub fn is_refused(revision: u16) -> bool {
    revision <= REVISION_Z
}

const MODULE: &str = "README of an ADC module for the STM32G4 (EmbedBits)";
const MODULES: &str = "READMEs of I2C, SPI and USART modules for the STM32G4 (EmbedBits)";
const SISTER: &str = "summary of ES0431 revision 7, the sheet of the STM32G431";

/// Errata by section.
pub const ERRATA: [Erratum; 20] = [
    Erratum {
        sections: "2.1.1",
        limitation: "a load to the stack pointer that an interrupt repeats leaves a wrong base register",
        handling: Handling::NotMet("the compiler loads the stack pointer only by `pop` and `mov`"),
        source: SISTER,
    },
    Erratum {
        sections: "2.1.2, 2.1.3",
        limitation: "errata of the Cortex-M4 r0p1: a division next to a very short interrupt; a store just before the return from one",
        handling: Handling::NotMet(
            "the only interrupt that returns has thousands of instructions, and nothing but the NMI, which ends in a reset, has a higher priority",
        ),
        source: "Arm errata 776924 and 838869, of the same core",
    },
    Erratum {
        sections: "2.2.1",
        limitation: "JTAG without NJTRST",
        handling: Handling::NotMet("the ST-LINK uses SWD"),
        source: SISTER,
    },
    Erratum {
        sections: "2.2.2",
        limitation: "the data cache may be wrong after the flash was changed",
        handling: Handling::Handled {
            how: "off while the flash is changed",
            test: Some(("sim-host/board-model/stm32g474/tests/part/rules/flash.rs", "Rule::FlashDataCache")),
        },
        source: "named in the code of this board before; not read again",
    },
    Erratum {
        sections: "2.2.3",
        limitation: "FLASH_ECCR may show a wrong address after an interrupted change of the flash",
        handling: Handling::Open(
            "the address decides whether a damaged word belongs to the settings; both copies of the settings are checked by their checksums in any case",
        ),
        source: "notes on the start-up of an STM32G474 project, which quotes revision 9",
    },
    Erratum {
        sections: "2.2.7",
        limitation: "the first write to a part of the RAM after a reset may be lost",
        handling: Handling::Handled {
            how: "each part is accessed before the first variable is written",
            test: Some(("tests/images/board_image.rs", "the_first_access_to_each_ram_is_not_needed")),
        },
        source: "the same notes; `pre_init` of Hubris for a related part (2.2.5 there)",
    },
    Erratum {
        sections: "2.4",
        limitation: "overrun flags of DMAMUX are lost",
        handling: Handling::NotMet("synchronisation and request generators are not used"),
        source: SISTER,
    },
    Erratum {
        sections: "2.7.1, 2.7.2, 2.7.5",
        limitation: "injected conversions: queue of contexts, wrong data register after a stop",
        handling: Handling::NotMet("no injected group"),
        source: MODULE,
    },
    Erratum { sections: "2.7.3", limitation: "a limitation of dual mode", handling: Handling::Unread, source: MODULE },
    Erratum {
        sections: "2.7.4",
        limitation: "the output of an analog watchdog is reset by other channels",
        handling: Handling::NotMet("analog watchdogs are not used"),
        source: MODULE,
    },
    Erratum {
        sections: "2.7.6",
        limitation: "dual regular simultaneous mode, one DMA channel, OVRMOD = 0: the data of the slave may be shifted by a sample",
        handling: Handling::Handled {
            how: "OVRMOD = 1 in both; OVR still ends the blocks. A current that becomes a sample late ends a tracked drive by fault 20, unless the stack rings for less than four blocks",
            test: Some(("sim-host/board-model/stm32g474/tests/part/rules/converters.rs", "Rule::AdcDualFifo")),
        },
        source: "Zephyr driver for the STM32G474; rusefi issue 9597 and ChibiOS pull request 64 (ArduPilot) for related parts",
    },
    Erratum {
        sections: "2.7.7, 2.7.8",
        limitation: "revision Z: conversions of several ADCs disturb each other if resolution or channels differ",
        handling: Handling::Refused("REV_ID up to 0x2001: the slow channels convert at any time"),
        source: "the ADC module; a data logger for the STM32G474, which quotes revision 6",
    },
    Erratum {
        sections: "2.7.9",
        limitation: "the first conversion more than 1 ms after the last one, or after the calibration, is wrong",
        handling: Handling::Handled {
            how: "slow channels convert twice and keep the second result; the block stream converts twice per microsecond",
            test: None,
        },
        source: "the ADC module; MicroPython pull request 11966",
    },
    Erratum {
        sections: "2.7.10",
        limitation: "revision Y: channel 0 is converted after a stop by software, or after one-shot DMA",
        handling: Handling::NotMet("no conversion is stopped, and DMA is circular"),
        source: "the ADC module; notes on a motor controller, which quote revision 8",
    },
    Erratum {
        sections: "2.7.11",
        limitation: "ADCs that convert at the same time disturb each other unless they have the same clock without a prescaler, \
                     or a common trigger whose period is a multiple of the prescaler",
        handling: Handling::Open(
            "V and I have one clock and one trigger, but 85 cycles are not a multiple of the prescaler 4, and the force, supply and \
             temperature channels start by software at any time",
        ),
        source: "moteus (mjbots) commit 4db3610 and its comments (2.7.9 of revision 8); two projects that quote revision 9",
    },
    Erratum {
        sections: "2.10, 2.12",
        limitation: "comparators; timers",
        handling: Handling::Unread,
        source: "section numbers in notes on a motor controller",
    },
    Erratum {
        sections: "2.15",
        limitation: "I2C: sampling, bus errors, stalls",
        handling: Handling::NotMet("no I2C"),
        source: MODULES,
    },
    Erratum {
        sections: "2.17.1",
        limitation: "LPUART: transmission fails with BRR from 0x301 to 0x3FF",
        handling: Handling::Handled {
            how: "such dividers are refused at compile time; BRR is 47 222",
            test: Some(("tests/board/errata.rs", "dividers_with_which_the_uart_fails_are_refused")),
        },
        source: MODULES,
    },
    Erratum {
        sections: "2.16, 2.18, 2.19, 2.20",
        limitation: "USART, SPI, FDCAN, USB",
        handling: Handling::NotMet("none is used"),
        source: "control specification of a project for the STM32G474, which quotes revision 9",
    },
    Erratum {
        sections: "ES0418 2.7.1",
        limitation: "DAC of the STM32G0: data written before the mode may be lost; not stated for the STM32G4",
        handling: Handling::Handled { how: "the mode is written before the data", test: None },
        source: "ES0418; precaution",
    },
];
