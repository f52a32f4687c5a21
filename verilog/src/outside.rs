//! A memory behind a machine's port to outside memory: it comes with an export, so that the machine runs in anyone's testbench.

use crate::module::Signal;

/// The module's name; its file is that with `.v`.
pub const OUTSIDE_MEMORY: &str = "outside_memory";

/// The module.
pub const TEXT: &str = r"// A memory behind a machine's port to outside memory.
//
// It takes a request a cycle, a read or a write. A read is answered LATENCY cycles later, or when all before it are;
// an answer stays until it is taken. For simulation: a chip has a memory controller in its place.
//
// Its outputs go to the machine's inputs of these names, its inputs come from the machine's outputs: request_ready_o to
// outside_ready, response_valid_o and response_word_o to outside_response_*; request_*_i and response_ready_i come from
// *_outside_request_* and *_outside_response_ready. A word that the machine has in two parts, *_high and *_low, is
// {high, low}.
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

/// A port, as the testbench has it, and its bits.
type Wire = (String, u32);

/// The input whose name ends so, in the vector of all inputs.
fn input(inputs: &[Signal], name: &str) -> Option<Wire> {
    let k = inputs.iter().position(|port| port.name.ends_with(name))?;
    let (at, bits) = (inputs[..k].iter().map(|port| port.width).sum::<u32>(), inputs[k].width);
    Some((format!("inputs[{at} +: {bits}]"), bits))
}

/// The output whose name ends so: the shortest, as a part of the machine that shares the port may have one, too.
fn output(outputs: &[Signal], name: &str) -> Option<Wire> {
    let those = outputs.iter().filter(|port| port.name.ends_with(name));
    let port = those.min_by_key(|port| port.name.len())?;
    Some((port.name.clone(), port.width))
}

/// The parts of a word that there are, as one.
fn word(high: Option<Wire>, low: Option<Wire>) -> Wire {
    let (wires, bits): (Vec<String>, Vec<u32>) = [high, low].into_iter().flatten().unzip();
    (format!("{{{}}}", wires.join(", ")), bits.iter().sum())
}

impl OutsideMemory {
    /// The memory beside a machine with these ports, and `agrees`: whether it shows what the machine's inputs are.
    pub(crate) fn beside(self, inputs: &[Signal], outputs: &[Signal]) -> String {
        let input = |name: &str| input(inputs, &format!("outside_{name}_i"));
        let output = |name: &str| output(outputs, &format!("outside_{name}_o"));
        let (asked, _) =
            word(output("request_payload_word_high"), output("request_payload_word_low"));
        let (replayed, bits) = word(input("response_payload_high"), input("response_payload_low"));
        let address = output("request_payload_address").unwrap_or_default();
        let named = |wire: Option<Wire>| wire.unwrap_or_default().0;
        let pins = [
            ("clk", "clk".to_string()),
            ("rst", "rst".to_string()),
            ("request_ready_o", "memory_ready".to_string()),
            ("request_valid_i", named(output("request_valid"))),
            ("request_write_i", named(output("request_payload_write"))),
            ("request_address_i", address.0),
            ("request_word_i", asked),
            ("response_valid_o", "memory_valid".to_string()),
            ("response_ready_i", named(output("response_ready"))),
            ("response_word_o", "memory_word".to_string()),
        ];
        let pins = pins.map(|(pin, wire)| format!("    .{pin}({wire})")).join(",\n");
        let OutsideMemory { words, latency } = self;
        let (top, address_bits) = (bits - 1, address.1);
        let (ready, valid) = (named(input("ready")), named(input("response_valid")));
        format!(
            "  // The memory of the export, which has to do as the one of the recorded run did.
  wire memory_ready, memory_valid;
  wire [{top}:0] memory_word;
  {OUTSIDE_MEMORY} #(.WORDS({words}), .BITS({bits}), .ADDR_BITS({address_bits}), .LATENCY({latency})) memory (
{pins}
  );
  wire agrees = memory_ready === {ready} && memory_valid === {valid} &&
    (!memory_valid || memory_word === {replayed});
"
        )
    }
}
