//! The monitor on a NUCLEO-G474RE: TIM3 triggers the converter 6400 times a second, DMA fills a ring, the log leaves by DMA.
#![no_std]
#![no_main]

use ballrace::phase::PhaseDelta;
use ballrace::twin::DamageDetector;
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_futures::join::join;
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, Exten, SampleTime};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::{MasterMode, RoundTo, Timer};
use embassy_stm32::timer::qei::Qei;
use embassy_stm32::triggers::TIM3_TRGO;
use embassy_stm32::usart::{self, UartTx};
use embassy_stm32::{bind_interrupts, dma, peripherals, rcc};
use embassy_time::Instant;
use monitor::{CHANNELS, Counts, FRAME, Frames, Monitor, RATE, SAMPLES};
use panic_probe as _;
use static_cell::ConstStaticCell;

bind_interrupts!(struct Irqs {
    DMA1_CHANNEL1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
    DMA1_CHANNEL2 => dma::InterruptHandler<peripherals::DMA1_CH2>;
});

static RING: ConstStaticCell<[u16; 2 * CHANNELS * SAMPLES]> = ConstStaticCell::new([0; 2 * CHANNELS * SAMPLES]);
static COUNTS: ConstStaticCell<Counts> = ConstStaticCell::new([0; CHANNELS * SAMPLES]);
static FRAMES: ConstStaticCell<[Frames; 2]> = ConstStaticCell::new([[0; FRAME * SAMPLES]; 2]);
static DETECTOR: ConstStaticCell<DamageDetector<f32>> = ConstStaticCell::new(DamageDetector::new());

/// Returns 160 MHz from the crystal of 24 MHz: whole cycles for a sample and for a bit.
fn clocks() -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
    config.rcc.hse = Some(rcc::Hse { freq: Hertz(24_000_000), mode: rcc::HseMode::Oscillator });
    config.rcc.pll = Some(rcc::Pll {
        source: rcc::PllSource::HSE,
        prediv: rcc::PllPreDiv::DIV6,
        mul: rcc::PllMul::MUL80,
        divp: None,
        divq: None,
        divr: Some(rcc::PllRDiv::DIV2),
    });
    config.rcc.sys = rcc::Sysclk::PLL1_R;
    config.rcc.boost = true;
    config.rcc.mux.adc12sel = rcc::mux::Adcsel::SYS;
    config
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_stm32::init(clocks());
    let Some(mut monitor) = Monitor::try_new(DETECTOR.take()) else { defmt::panic!("constants in flash are damaged") };
    let mut alarm = Output::new(p.PA5, Level::Low, Speed::Low);

    // Encoder of 1024 lines: 4096 counts per revolution.
    let encoder = Qei::new(p.TIM4, p.PB6, p.PB7, Default::default());

    let mut serial = usart::Config::default();
    serial.baudrate = 2_000_000;
    let Ok(mut log) = UartTx::new(p.LPUART1, p.PA2, p.DMA1_CH2, Irqs, serial) else { defmt::panic!("baud rate") };

    let channels = [p.PA0.degrade_adc(), p.PA1.degrade_adc(), p.PB0.degrade_adc()];
    let sequence = channels.into_iter().map(|channel| (channel, SampleTime::CYCLES47_5));
    let adc = Adc::new(p.ADC1, AdcConfig::default());
    let mut adc = adc.into_ring_buffered(p.DMA1_CH1, RING.take(), Irqs, sequence, TIM3_TRGO, Exten::RISING_EDGE);
    let clock = Timer::new(p.TIM3);
    clock.set_frequency(Hertz(RATE), RoundTo::Slower);
    clock.set_master_mode(MasterMode::UPDATE);

    let counts = COUNTS.take();
    let [mut sent, mut next] = FRAMES.take().each_mut();
    // No frame before the first block.
    let mut length = 0;
    let mut position = encoder.count();
    let start = Instant::now();
    adc.start();
    clock.start();
    loop {
        // The frames of the last block leave while the converter fills this one.
        let block = async { (adc.read(counts).await, encoder.count()) };
        let (written, (read, now)) = join(log.write(&sent[..length]), block).await;
        if written.is_err() {
            defmt::warn!("frames lost");
        }
        // Counts of the encoder in 256 samples: 2^-12 revolution each, 2^-20 a sample.
        let turned = PhaseDelta(i64::from(now.wrapping_sub(position).cast_signed()) << 44);
        position = now;
        if read.is_err() {
            defmt::warn!("blocks lost");
            monitor.continue_at((start.elapsed().as_micros() * u64::from(RATE) / 1_000_000 / SAMPLES as u64) as u32);
            length = 0;
            continue;
        }
        if let Some(verdict) = monitor.block(counts, turned, next) {
            alarm.set_level(verdict.damage.named.is_some().into());
            defmt::info!("{}", verdict);
        }
        core::mem::swap(&mut sent, &mut next);
        length = sent.len();
    }
}
