//! Circular DMA and its rings. RM0440 12 (DMA) and 13 (DMAMUX).
//!
//! | channel | request (RM0440 table 91) | moves |
//! |---|---|---|
//! | DMA1 1 | 5, ADC1 | `V` and `I` as one word into the ring of the ADC pair; half and end raise the block interrupt |
//! | DMA1 2 | 6, DAC1 channel 1, or 102, DAC3 channel 1 | lanes 0 and 1 as one word |
//! | DMA1 3 | 104, DAC4 channel 1 | lanes 2 and 3 as one word |
//! | DMA2 1 | 34, LPUART1 RX | bytes of the link |
//!
//! All transfers at the converters are of 32 bits: a DAC of this family faults on narrower
//! accesses.
#![expect(unsafe_code, reason = "rings that DMA and the processor use at the same time")]

use core::cell::UnsafeCell;
use core::ptr;

use stm32_metapac::bdma::Dma;
use stm32_metapac::bdma::vals::{Dir, Pl, Size};
use stm32_metapac::{DMA1, DMA2, DMAMUX1};

/// Element of memory that DMA and the processor share.
#[repr(transparent)]
pub struct Place<T>(UnsafeCell<T>);

// SAFETY: every access is volatile and of one element, and each element is a word or a byte that is
// accessed in one transfer. `blocks` and `ring` decide which elements may be used when; a mistake
// there causes a wrong code, not a broken invariant.
unsafe impl<T: Copy + Send> Sync for Place<T> {}

impl<T: Copy> Place<T> {
    /// Reads the value.
    pub fn read(&self) -> T {
        // SAFETY: aligned, and initialised; volatile, because DMA writes it.
        unsafe { ptr::read_volatile(self.0.get()) }
    }

    /// Writes the value.
    pub fn write(&self, value: T) {
        // SAFETY: aligned; volatile, because DMA reads it. Only one execution level writes to any
        // ring.
        unsafe { ptr::write_volatile(self.0.get(), value) }
    }
}

/// Ring of elements that DMA and the processor share.
pub struct Ring<T, const N: usize>(UnsafeCell<[T; N]>);

// SAFETY: access is only possible through its elements, which are `Sync`.
unsafe impl<T: Copy + Send, const N: usize> Sync for Ring<T, N> {}

impl<T: Copy, const N: usize> Ring<T, N> {
    /// Creates a ring filled with one value.
    pub const fn new(value: T) -> Self {
        Ring(UnsafeCell::new([value; N]))
    }

    /// Returns the elements of the ring.
    pub fn places(&self) -> &[Place<T>; N] {
        // SAFETY: an element has the layout of its value, and the cell of the array permits the
        // same access as the cell of an element.
        unsafe { &*self.0.get().cast() }
    }

    fn address(&self) -> u32 {
        self.0.get() as u32
    }
}

/// Direction of a channel.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From a peripheral into a ring, with interrupts at half and end.
    InWithInterrupts,
    /// From a peripheral into a ring.
    In,
    /// From a ring to a peripheral.
    Out,
}

/// DMA channel, counted from zero.
#[derive(Clone, Copy)]
pub struct Channel {
    dma: Dma,
    number: usize,
    multiplexer: usize,
}

impl Channel {
    /// Creates a channel of the first controller: DMAMUX channels 0 to 7 (RM0440 13.3.2).
    pub const fn of_dma1(number: usize) -> Self {
        Channel { dma: DMA1, number, multiplexer: number }
    }

    /// Creates a channel of the second controller: DMAMUX channels 8 to 15.
    pub const fn of_dma2(number: usize) -> Self {
        Channel { dma: DMA2, number, multiplexer: 8 + number }
    }

    /// Starts circular transfers between a register of a peripheral and a ring, one at each request
    /// of the peripheral.
    pub fn start<T: Copy, const N: usize>(
        self,
        request: u8,
        register: *mut (),
        ring: &'static Ring<T, N>,
        direction: Direction,
        priority: Pl,
    ) {
        let channel = self.dma.ch(self.number);
        let size = if size_of::<T>() == 1 { Size::BITS8 } else { Size::BITS32 };
        // The channel must be off while it is configured (12.4.3).
        channel.cr().write(|_| ());
        // DMAMUX_CxCR.DMAREQ_ID (13.6.1).
        DMAMUX1.ccr(self.multiplexer).write(|w| w.set_dmareq_id(request));
        // DMA_CPARx (12.6.5), DMA_CMARx (12.6.6), DMA_CNDTRx (12.6.4).
        channel.par().write_value(register as u32);
        channel.mar().write_value(ring.address());
        channel.ndtr().write(|w| w.set_ndt(N as u16));
        // DMA_CCRx (12.6.3).
        channel.cr().write(|w| {
            w.set_dir(if direction == Direction::Out { Dir::FROM_MEMORY } else { Dir::FROM_PERIPHERAL });
            w.set_circ(true);
            w.set_minc(true);
            w.set_msize(size);
            w.set_psize(size);
            w.set_pl(priority);
            w.set_htie(direction == Direction::InWithInterrupts);
            w.set_tcie(direction == Direction::InWithInterrupts);
            w.set_teie(direction == Direction::InWithInterrupts);
            w.set_en(true);
        });
    }

    /// Returns the number of transfers until the ring restarts: DMA_CNDTRx (12.6.4).
    pub fn remaining(self) -> u16 {
        self.dma.ch(self.number).ndtr().read().ndt()
    }

    /// Clears the channel's flags. Returns `true` if a transfer has failed, which stops the
    /// channel: DMA_ISR (12.6.1), DMA_IFCR (12.6.2).
    pub fn acknowledge(self) -> bool {
        let failed = self.dma.isr().read().teif(self.number);
        self.dma.ifcr().write(|w| {
            w.set_htif(self.number, true);
            w.set_tcif(self.number, true);
            w.set_teif(self.number, true);
        });
        failed
    }
}
