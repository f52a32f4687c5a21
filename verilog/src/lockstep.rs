//! The lock-step testbench: replays a recorded run and compares every output port on every cycle.
//!
//! The vectors are text, a line for each run of equal cycles: how many, `rst`, the inputs and the
//! outputs that are expected, as hexadecimal numbers whose lowest bits are the first port's.

use crate::module::{Signal, ports};
use crate::outside::OutsideMemory;
use pellucid_sim::netlist::Module;
use std::fmt::Write;

/// Vectors to be written.
pub struct Vectors<W> {
    out: W,
    widths: [Vec<u32>; 2],
    /// The line under way, and for how many cycles it holds.
    line: String,
    times: u64,
    next: String,
}

/// Packs numbers of some widths as a hexadecimal number.
fn pack(widths: &[u32], values: &[u64], to: &mut String) {
    let mut digits = vec![];
    let (mut held, mut bits) = (0u128, 0);
    for (width, value) in widths.iter().zip(values) {
        held |= u128::from(*value) << bits;
        bits += width;
        while bits >= 4 {
            digits.push((held & 15) as u8);
            held >>= 4;
            bits -= 4;
        }
    }
    if bits > 0 || digits.is_empty() {
        digits.push(held as u8);
    }
    to.extend(digits.iter().rev().map(|d| char::from_digit(u32::from(*d), 16).unwrap_or('0')));
}

impl<W: std::io::Write> Vectors<W> {
    /// Vectors for the ports of `module`.
    pub fn new(module: &Module, out: W) -> Vectors<W> {
        let (inputs, outputs) = ports(module);
        let widths = |ports: &[Signal]| ports.iter().map(|port| port.width).collect();
        let widths = [widths(&inputs), widths(&outputs)];
        Vectors { out, widths, line: String::new(), times: 0, next: String::new() }
    }

    /// One cycle with these inputs, in which these outputs are expected.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn cycle(&mut self, inputs: &[u64], outputs: &[u64]) -> std::io::Result<()> {
        self.push(false, inputs, outputs)
    }

    /// One cycle of reset, in which nothing is compared.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn reset(&mut self) -> std::io::Result<()> {
        self.push(true, &[], &[])
    }

    fn push(&mut self, reset: bool, inputs: &[u64], outputs: &[u64]) -> std::io::Result<()> {
        let mut next = std::mem::take(&mut self.next);
        next.clear();
        next.push(if reset { '1' } else { '0' });
        next.push(' ');
        pack(&self.widths[0], inputs, &mut next);
        next.push(' ');
        pack(&self.widths[1], outputs, &mut next);
        if next == self.line {
            self.times += 1;
            self.next = next;
        } else {
            self.flush()?;
            self.next = std::mem::replace(&mut self.line, next);
            self.times = 1;
        }
        Ok(())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        if self.times > 0 {
            writeln!(self.out, "{} {}", self.times, self.line)?;
        }
        Ok(())
    }

    /// Ends the vectors and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self) -> std::io::Result<W> {
        self.flush()?;
        Ok(self.out)
    }
}

/// The testbench for `module`, whose text calls it `name`; it reads the file `vectors`. What comes through the port to
/// outside memory is replayed with the other inputs; if `memory` is given, one is beside the machine and compared, too.
pub fn testbench(
    module: &Module,
    name: &str,
    vectors: &str,
    memory: Option<OutsideMemory>,
) -> String {
    let (inputs, outputs) = ports(module);
    let bits = |ports: &[Signal]| ports.iter().map(|port| port.width).sum::<u32>().max(1);
    let (in_bits, out_bits) = (bits(&inputs), bits(&outputs));
    let mut wires = String::new();
    let mut pins = String::from("    .clk(clk),\n    .rst(rst),\n    .en_i(1'b1)");
    let mut compare = String::new();
    let mut at = 0;
    for port in &inputs {
        let _ = write!(pins, ",\n    .{}(inputs[{at} +: {}])", port.name, port.width);
        at += port.width;
    }
    let mut at = 0;
    for Signal { name, width } in &outputs {
        let _ = writeln!(wires, "  wire [{}:0] {name};", width - 1);
        let _ = write!(pins, ",\n    .{name}({name})");
        let _ = writeln!(
            compare,
            "        if ({name} !== expected[{at} +: {width}])\n          \
             $display(\"cycle %0d: {name} is %h, expected %h\", cycle, {name}, expected[{at} +: {width}]);"
        );
        at += width;
    }
    let all: Vec<&str> = outputs.iter().rev().map(|port| port.name.as_str()).collect();
    let all = all.join(",\n          ");
    let agrees = "  wire agrees = 1'b1;\n".to_string();
    let memory = memory.map_or(agrees, |memory| memory.beside(&inputs, &outputs));
    format!(
        r#"// Replays {vectors} and compares every output of {name} on every cycle.
module lockstep_tb;
  reg clk = 1'b0;
  reg rst = 1'b1;
  reg [{in_top}:0] inputs = {in_bits}'d0;
  reg [{out_top}:0] expected = {out_bits}'d0;
  // A line is read into these: Verilator does not see that $fscanf changes what a port reads.
  reg next_rst;
  reg [{in_top}:0] next_inputs;
  reg [{out_top}:0] next_expected;
  // All outputs side by side, only when they are looked at: as a wire they would be put together again for each change.
  reg [{out_top}:0] found;
  integer file, read, times, k;
  integer cycle = 0;
  integer different = 0;

{wires}  {name} dut (
{pins}
  );
{memory}
  initial begin
    file = $fopen("{vectors}", "r");
    if (file == 0) begin
      $display("FAIL: cannot read {vectors}");
      $stop;
    end
    // Power-up: one cycle of reset.
    #5 clk = 1'b1;
    #5 clk = 1'b0;
    read = $fscanf(file, "%d %b %h %h\n", times, next_rst, next_inputs, next_expected);
    while (read == 4 && different < 10) begin
      rst = next_rst;
      inputs = next_inputs;
      expected = next_expected;
      for (k = 0; k < times && different < 10; k = k + 1) begin
        #4;
        found = {{
          {all}
        }};
        if (!rst && (found !== expected || !agrees)) begin
          different = different + 1;
          if (!agrees) $display("cycle %0d: the outside memory answers otherwise", cycle);
{compare}        end
        #1 clk = 1'b1;
        #5 clk = 1'b0;
        if (!rst) cycle = cycle + 1;
      end
      read = $fscanf(file, "%d %b %h %h\n", times, next_rst, next_inputs, next_expected);
    end
    if (cycle == 0 || different != 0) begin
      $display("FAIL: %0d cycles, %0d of them different", cycle, different);
      $stop;
    end
    $display("PASS: %0d cycles, every output equal", cycle);
    $finish;
  end
endmodule
"#,
        in_top = in_bits - 1,
        out_top = out_bits - 1,
    )
}
