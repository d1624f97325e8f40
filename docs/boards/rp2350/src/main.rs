//! The monitor on a Raspberry Pi Pico 2: the converter runs by its own clock, DMA fills a ring without an end, the log leaves by DMA.
#![no_std]
#![no_main]

use ballrace::phase::PhaseDelta;
use ballrace::twin::DamageDetector;
use core::sync::atomic::{AtomicU16, Ordering};
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_futures::join::join;
use embassy_rp::adc::{self, Adc};
use embassy_rp::gpio::{Level, Output, Pull};
use embassy_rp::pac::dma::vals::{DataSize, TransCountMode, TreqSel};
use embassy_rp::pwm::{self, InputMode, Pwm};
use embassy_rp::uart::{self, UartTx};
use embassy_rp::{bind_interrupts, dma, pac, peripherals};
use embassy_time::{Duration, Instant, Timer};
use monitor::{CHANNELS, Counts, FRAME, Frames, Monitor, RATE, SAMPLES};
use panic_probe as _;
use static_cell::ConstStaticCell;

bind_interrupts!(struct Irqs {
    ADC_IRQ_FIFO => adc::InterruptHandler;
    DMA_IRQ_0 => dma::InterruptHandler<peripherals::DMA_CH0>, dma::InterruptHandler<peripherals::DMA_CH1>;
});

/// Counts of the ring: DMA wraps at a power of two, 2.7 blocks.
const RING_COUNTS: usize = 2048;
const RING_BYTES_LOG2: u8 = 12;
/// Cycles of the 48 MHz clock of the converter from one channel to the next.
const CYCLES: u32 = 48_000_000 / (RATE * CHANNELS as u32);
/// Duration of a block, in ticks of 1 us. The crystal is also that of the converter, so that both stay in step.
const BLOCK_TICKS: u64 = SAMPLES as u64 * 1_000_000 / RATE as u64;
/// Time after its end in which a block is not yet written over: 66 ms less a margin.
const SLACK: Duration = Duration::from_millis(60);

/// The ring, which DMA writes and the program reads: atomic, and aligned to its size.
#[repr(align(4096))]
struct Ring([AtomicU16; RING_COUNTS]);

static RING: Ring = Ring([const { AtomicU16::new(0) }; RING_COUNTS]);
static COUNTS: ConstStaticCell<Counts> = ConstStaticCell::new([0; CHANNELS * SAMPLES]);
static FRAMES: ConstStaticCell<[Frames; 2]> = ConstStaticCell::new([[0; FRAME * SAMPLES]; 2]);
static DETECTOR: ConstStaticCell<DamageDetector<f32>> = ConstStaticCell::new(DamageDetector::new());

impl Ring {
    /// Starts the conversion of the channels 0 to 2 in turn, and the transfer without an end.
    fn start(&'static self, channel: &dma::Channel<'_>) {
        let registers = channel.regs();
        registers.read_addr().write_value(pac::ADC.fifo().as_ptr() as u32);
        registers.write_addr().write_value(self.0.as_ptr() as u32);
        registers.trans_count().write(|w| {
            w.set_mode(TransCountMode::ENDLESS);
            w.set_count(1);
        });
        registers.ctrl_trig().write(|w| {
            w.set_treq_sel(TreqSel::ADC);
            w.set_data_size(DataSize::SIZE_HALFWORD);
            w.set_incr_write(true);
            w.set_ring_sel(true);
            w.set_ring_size(RING_BYTES_LOG2);
            w.set_en(true);
        });
        pac::ADC.fcs().write(|w| {
            w.set_thresh(1);
            w.set_dreq_en(true);
            w.set_en(true);
        });
        pac::ADC.div().write(|w| w.set_int((CYCLES - 1) as u16));
        pac::ADC.cs().modify(|w| {
            w.set_ainsel(0);
            w.set_rrobin(0b111);
            w.set_start_many(true);
        });
    }

    /// Copies a block, counted from the start.
    fn read(&self, block: u64, counts: &mut Counts) {
        let from = (block * counts.len() as u64 % RING_COUNTS as u64) as usize;
        for (count, slot) in counts.iter_mut().zip(self.0.iter().cycle().skip(from)) {
            *count = slot.load(Ordering::Relaxed);
        }
    }
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_rp::init(Default::default());
    let Some(mut monitor) = Monitor::try_new(DETECTOR.take()) else { defmt::panic!("constants in flash are damaged") };
    let mut alarm = Output::new(p.PIN_25, Level::Low);

    // Track A of an encoder of 1024 lines: rising edges, 1024 counts per revolution.
    let encoder = Pwm::new_input(p.PWM_SLICE7, p.PIN_15, Pull::None, InputMode::RisingEdge, pwm::Config::default());

    let mut serial = uart::Config::default();
    serial.baudrate = 2_000_000;
    let mut log = UartTx::new(p.UART0, p.PIN_0, p.DMA_CH1, Irqs, serial);

    let _adc = Adc::new(p.ADC, Irqs, adc::Config::default());
    let _channels = [
        adc::Channel::new_pin(p.PIN_26, Pull::None),
        adc::Channel::new_pin(p.PIN_27, Pull::None),
        adc::Channel::new_pin(p.PIN_28, Pull::None),
    ];
    let channel = dma::Channel::new(p.DMA_CH0, Irqs);

    let counts = COUNTS.take();
    let [mut sent, mut next] = FRAMES.take().each_mut();
    // No frame before the first block.
    let mut length = 0;
    let mut block = 0;
    let mut position = encoder.counter();
    let start = Instant::now();
    RING.start(&channel);
    loop {
        // The frames of the last block leave while the converter fills this one.
        let end = start + Duration::from_ticks((block + 1) * BLOCK_TICKS);
        let (written, now) = join(log.write(&sent[..length]), async {
            Timer::at(end).await;
            encoder.counter()
        })
        .await;
        if written.is_err() {
            defmt::warn!("frames lost");
        }
        // Counts of the encoder in 256 samples: 2^-10 revolution each, 2^-18 a sample.
        let turned = PhaseDelta(i64::from(now.wrapping_sub(position)) << 46);
        position = now;
        RING.read(block, counts);
        if Instant::now() > end + SLACK {
            defmt::warn!("blocks lost");
            block = start.elapsed().as_ticks() / BLOCK_TICKS;
            monitor.continue_at(block as u32);
            length = 0;
            continue;
        }
        block += 1;
        if let Some(verdict) = monitor.block(counts, turned, next) {
            alarm.set_level(verdict.damage.named.is_some().into());
            defmt::info!("{}", verdict);
        }
        core::mem::swap(&mut sent, &mut next);
        length = sent.len();
    }
}
