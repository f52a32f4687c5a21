//! A memory behind a machine's port to outside memory: it comes with an export, so that the machine runs in anyone's testbench.

use crate::module::Signal;
use std::fmt::Write;

/// The module's name; its file is that with `.v`.
pub const OUTSIDE_MEMORY: &str = "outside_memory";

/// The module.
pub const TEXT: &str = r"// A memory behind a machine's port to outside memory.
//
// It takes a request a cycle, a read or a write. A read is answered LATENCY cycles later, or when all before it are;
// an answer stays until it is taken. For simulation: a chip has a memory controller in its place.
module outside_memory #(
  parameter WORDS = 2,
  parameter BITS = 1,
  parameter ADDR_BITS = 1,
  parameter LATENCY = 1
) (
  input clk,
  input rst,
  output request_ready_o,
  input request_valid_i,
  input request_write_i,
  input [ADDR_BITS-1:0] request_address_i,
  input [BITS-1:0] request_word_i,
  output response_valid_o,
  input response_ready_i,
  output [BITS-1:0] response_word_o
);
  reg [BITS-1:0] words [0:WORDS-1];
  // Answers in a ring, each with the cycle from which on it is shown.
  reg [BITS-1:0] answer_q [0:LATENCY];
  reg [31:0] due_q [0:LATENCY];
  reg [31:0] now_q, first_q, next_q, count_q;
  assign request_ready_o = count_q <= LATENCY;
  assign response_valid_o = count_q != 0 && now_q - due_q[first_q] < 32'h80000000;
  assign response_word_o = answer_q[first_q];
  wire taken = request_valid_i && request_ready_o;
  wire reads = taken && !request_write_i;
  wire answered = response_valid_o && response_ready_i;
  always @(posedge clk)
    if (rst) begin
      now_q <= 0;
      first_q <= 0;
      next_q <= 0;
      count_q <= 0;
    end else begin
      now_q <= now_q + 1;
      if (taken && request_write_i) words[request_address_i] <= request_word_i;
      if (reads) begin
        answer_q[next_q] <= words[request_address_i];
        due_q[next_q] <= now_q + LATENCY;
        next_q <= next_q == LATENCY ? 0 : next_q + 1;
      end
      if (answered) first_q <= first_q == LATENCY ? 0 : first_q + 1;
      count_q <= count_q + {31'd0, reads} - {31'd0, answered};
    end
endmodule
";

/// The memory as a testbench has it beside a machine.
#[derive(Clone, Copy, Debug)]
pub struct OutsideMemory {
    /// Words that it has.
    pub words: u32,
    /// Cycles from a read request to its answer.
    pub latency: u32,
}

/// Where a port is among those of its direction: its lowest bit and how many it has.
fn place(ports: &[Signal], name: &str) -> Option<(u32, u32)> {
    let at = ports.iter().position(|port| port.name.ends_with(name))?;
    Some((ports[..at].iter().map(|port| port.width).sum(), ports[at].width))
}

impl OutsideMemory {
    /// The memory beside a machine with these ports, and `agrees`: whether it shows what the machine's inputs are.
    pub(crate) fn beside(self, inputs: &[Signal], outputs: &[Signal]) -> String {
        let input =
            |name: &str| place(inputs, name).map(|(at, bits)| format!("inputs[{at} +: {bits}]"));
        let output = |name: &str| {
            let port = outputs.iter().find(|port| port.name.ends_with(name));
            port.map(|port| port.name.as_str())
        };
        let of = |parts: [Option<String>; 2]| {
            let parts: Vec<String> = parts.into_iter().flatten().collect();
            format!("{{{}}}", parts.join(", "))
        };
        let word = |name: &str| output(name).map(str::to_string);
        let asked = of(["request_payload_word_high_o", "request_payload_word_low_o"].map(word));
        let replayed =
            of(["outside_response_payload_high_i", "outside_response_payload_low_i"].map(input));
        let bits = |name: &str| place(inputs, name).map_or(0, |(_, bits)| bits);
        let bits = bits("outside_response_payload_low_i") + bits("outside_response_payload_high_i");
        let address = "outside_request_payload_address_o";
        let address_bits = place(outputs, address).map_or(1, |(_, bits)| bits);
        let named = |name: &str| output(name).unwrap_or("1'b0").to_string();
        let pins = [
            ("clk", "clk".to_string()),
            ("rst", "rst".to_string()),
            ("request_ready_o", "memory_ready".to_string()),
            ("request_valid_i", named("outside_request_valid_o")),
            ("request_write_i", named("outside_request_payload_write_o")),
            ("request_address_i", named(address)),
            ("request_word_i", asked),
            ("response_valid_o", "memory_valid".to_string()),
            ("response_ready_i", named("outside_response_ready_o")),
            ("response_word_o", "memory_word".to_string()),
        ];
        let pins = pins.map(|(pin, wire)| format!("    .{pin}({wire})")).join(",\n");
        let given = |name: &str| input(name).unwrap_or_default();
        let mut text = String::new();
        let _ = write!(
            text,
            "  // The memory of the export, which has to do as the one of the recorded run did.\n  \
               wire memory_ready, memory_valid;\n  \
               wire [{top}:0] memory_word;\n  \
               {OUTSIDE_MEMORY} #(.WORDS({words}), .BITS({bits}), .ADDR_BITS({address_bits}), .LATENCY({latency})) memory (\n\
             {pins}\n  );\n  \
               wire agrees = memory_ready === {ready} && memory_valid === {valid} &&\n    \
                 (!memory_valid || memory_word === {replayed});\n",
            top = bits.max(1) - 1,
            words = self.words,
            latency = self.latency,
            ready = given("outside_ready_i"),
            valid = given("outside_response_valid_i"),
        );
        text
    }
}
