//! What a run's waveform shows.

use anyhow::bail;
use clap::Args;
use pellucid_machine::Model;
use pellucid_machine::pixel::Screen;
use pellucid_testbench::recorder::{DEFAULT_WORDS, MOST_WORDS, WaveJob, Words};
use pellucid_testbench::window::{
    EVENTS, LONGEST_STALL, PHASE_CYCLES, Window, default_windows, range,
};
use pellucid_waveforms::FileFormat;
use std::path::Path;

#[derive(Args)]
#[command(next_help_heading = "Waveform")]
pub(super) struct WaveArgs {
    /// Cycles that the waveform shows, several with commas: FROM..TO, `store`, `resolve`, `all`, `stall:N` or
    /// `event:NAME` [default: store,resolve]
    #[arg(long, value_name = "WINDOW", value_delimiter = ',', allow_hyphen_values = true, long_help = windows_help())]
    wave: Vec<Window>,
    /// Shows a fragment, by its number in arrival order from 0, wherever it is; may be given several times
    #[arg(long, value_name = "ID")]
    follow_fragment: Vec<u32>,
    /// Shows all fragments of a pixel; may be given several times
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    follow_pixel: Vec<(u32, u32)>,
    /// Signals that it has, by path below the machine, several with commas: `*` stands for any text, the
    /// name of a scope for all in it, `!` leaves out, as in `registers.chains,wires,!*.label` [default: all]
    #[arg(long, value_name = "GLOB", value_delimiter = ',')]
    wave_scope: Vec<String>,
    /// Words of memories that it has as well, several with commas: PATH or PATH:FROM..TO, the path as
    /// `memories` in stats.json names it, `*` stands for any text [default: none]
    #[arg(long, value_name = "WORDS", value_delimiter = ',', value_parser = words, long_help = words_help())]
    wave_memory: Vec<Words>,
    /// Its file format
    #[arg(long, value_name = "FORMAT", default_value = "vcd", value_parser = ["vcd", "fst"])]
    wave_format: String,
    /// Write no waveform
    #[arg(long, conflicts_with_all = ["wave", "follow_fragment", "follow_pixel", "wave_scope", "wave_memory"])]
    no_wave: bool,
}

fn windows_help() -> String {
    let events = EVENTS.map(|event| format!("`{event}`")).join(", ");
    format!(
        "Cycles that the waveform shows, several with commas: FROM..TO, counted from the frame's start; `store` or \
         `resolve`, {PHASE_CYCLES} cycles from there on; `all`; `stall:N`, around the first stall of more than N \
         cycles, N from 1 to {LONGEST_STALL}; `event:NAME`, around the first time that the event happens: \
         {events}, as far as the machine has it [default: store,resolve]"
    )
}

fn words_help() -> String {
    format!(
        "Words of memories that it has as well, several with commas: PATH or PATH:FROM..TO, the path as \
         `memories` in stats.json names it, `*` stands for any text. Without FROM..TO the first \
         {DEFAULT_WORDS} words; {MOST_WORDS} words at most [default: none]"
    )
}

/// `X,Y`.
fn pixel(text: &str) -> Result<(u32, u32), String> {
    let parse = |text: &str| text.trim().parse().ok();
    let pixel = text.split_once(',').and_then(|(x, y)| Some((parse(x)?, parse(y)?)));
    pixel.ok_or_else(|| "expected a column and a row, as in `3,4`".to_string())
}

/// `PATH` or `PATH:FROM..TO`.
fn words(text: &str) -> Result<Words, String> {
    let Some((memory, words)) = text.split_once(':') else {
        return Ok(Words { memory: text.to_string(), range: None });
    };
    let range = range(words).ok_or("expected PATH or PATH:FROM..TO with FROM below TO")?;
    Ok(Words { memory: memory.to_string(), range: Some(range) })
}

impl WaveArgs {
    /// The waveform of a frame of so many items, in the folder `out`; nothing if none is wanted.
    pub(super) fn job(
        &self,
        out: &Path,
        machine: &dyn Model,
        items: u64,
    ) -> anyhow::Result<Option<WaveJob>> {
        if self.no_wave {
            return Ok(None);
        }
        let mut windows = self.wave.clone();
        for number in &self.follow_fragment {
            if u64::from(*number) >= items {
                bail!(
                    "--follow-fragment {number}: the frame has {items} fragments, numbered from 0"
                );
            }
            windows.push(Window::Fragment { number: *number });
        }
        for (x, y) in &self.follow_pixel {
            let Screen { width, height, .. } = machine.screen();
            if *x >= width || *y >= height {
                bail!("--follow-pixel {x},{y}: the screen has {width} columns and {height} rows");
            }
            windows.push(Window::Pixel { x: *x as u16, y: *y as u16 });
        }
        if windows.is_empty() {
            windows = default_windows(machine.phases());
        }
        let format = if self.wave_format == "fst" { FileFormat::Fst } else { FileFormat::Vcd };
        Ok(Some(WaveJob {
            path: out.join("wave").with_extension(format.extension()),
            format,
            windows,
            scopes: self.wave_scope.clone(),
            memories: self.wave_memory.clone(),
        }))
    }
}
