//! The memories as Verilog: what synthesis tools turn into RAM blocks.

/// A memory with one read and one write port.
pub const RAM_1R1W: &str = r"// A memory with one read port and one write port.
//
// A read asked for in a cycle shows its data, with valid_o high, LATENCY cycles later. With LATENCY 1 the
// data stays until the next read. With WRITE_FIRST a read that meets the write of its word in the same
// cycle gives the new data, else the old. Words are not reset.
module ram_1r1w #(
  parameter WORDS = 2,
  parameter BITS = 1,
  parameter ADDR_BITS = 1,
  parameter LATENCY = 1,
  parameter WRITE_FIRST = 1
) (
  input clk,
  input rst,
  input read_en_i,
  input [ADDR_BITS-1:0] read_addr_i,
  input write_en_i,
  input [ADDR_BITS-1:0] write_addr_i,
  input [BITS-1:0] write_data_i,
  output valid_o,
  output [BITS-1:0] data_o
);
  reg [BITS-1:0] words [0:WORDS-1];
  reg [BITS-1:0] read_data_q;
  reg valid_q;
  initial read_data_q = {BITS{1'b0}};
  wire read = read_en_i && !rst;
  always @(posedge clk) begin
    if (write_en_i && !rst) words[write_addr_i] <= write_data_i;
    if (read) read_data_q <= words[read_addr_i];
    valid_q <= read;
  end

  wire [BITS-1:0] data;
  generate
    if (WRITE_FIRST != 0) begin : write_first
      // The word that was written while it was read.
      reg bypass_q;
      reg [BITS-1:0] written_q;
      initial bypass_q = 1'b0;
      initial written_q = {BITS{1'b0}};
      always @(posedge clk)
        if (read) begin
          bypass_q <= write_en_i && write_addr_i == read_addr_i;
          written_q <= write_data_i;
        end
      assign data = bypass_q ? written_q : read_data_q;
    end else begin : read_first
      assign data = read_data_q;
    end
  endgenerate

  ram_delay #(.BITS(BITS), .STAGES(LATENCY - 1)) u_delay (
    .clk(clk), .rst(rst), .valid_i(valid_q), .data_i(data), .valid_o(valid_o), .data_o(data_o)
  );
endmodule
";

/// A memory with one port.
pub const RAM_1RW: &str = r"// A memory with one port that reads or writes.
//
// A read asked for in a cycle shows its data, with valid_o high, LATENCY cycles later. With LATENCY 1 the
// data stays until the next read. Words are not reset.
module ram_1rw #(
  parameter WORDS = 2,
  parameter BITS = 1,
  parameter ADDR_BITS = 1,
  parameter LATENCY = 1
) (
  input clk,
  input rst,
  input en_i,
  input write_i,
  input [ADDR_BITS-1:0] addr_i,
  input [BITS-1:0] data_i,
  output valid_o,
  output [BITS-1:0] data_o
);
  reg [BITS-1:0] words [0:WORDS-1];
  reg [BITS-1:0] read_data_q;
  reg valid_q;
  initial read_data_q = {BITS{1'b0}};
  wire access = en_i && !rst;
  always @(posedge clk) begin
    if (access && write_i) words[addr_i] <= data_i;
    if (access && !write_i) read_data_q <= words[addr_i];
    valid_q <= access && !write_i;
  end

  ram_delay #(.BITS(BITS), .STAGES(LATENCY - 1)) u_delay (
    .clk(clk), .rst(rst), .valid_i(valid_q), .data_i(read_data_q), .valid_o(valid_o),
    .data_o(data_o)
  );
endmodule
";

/// Read data on its way from a memory with a latency of more than one cycle.
pub const RAM_DELAY: &str = r"// Read data on its way from a memory: STAGES cycles.
module ram_delay #(
  parameter BITS = 1,
  parameter STAGES = 0
) (
  input clk,
  input rst,
  input valid_i,
  input [BITS-1:0] data_i,
  output valid_o,
  output [BITS-1:0] data_o
);
  generate
    if (STAGES == 0) begin : none
      assign valid_o = valid_i;
      assign data_o = data_i;
      wire unused = &{1'b0, clk, rst};
    end else begin : line
      localparam AT_BITS = STAGES > 1 ? $clog2(STAGES) : 1;
      localparam [31:0] LAST = STAGES - 1;
      // The data is in a ring: what stands where the next goes came in STAGES cycles ago.
      reg [STAGES-1:0] valid_q;
      reg [BITS-1:0] data_q [0:STAGES-1];
      reg [AT_BITS-1:0] at_q;
      wire [STAGES:0] valid = {valid_q, valid_i};
      integer k;
      initial begin
        at_q = {AT_BITS{1'b0}};
        for (k = 0; k < STAGES; k = k + 1) data_q[k] = {BITS{1'b0}};
      end
      always @(posedge clk)
        if (rst) valid_q <= {STAGES{1'b0}};
        else begin
          valid_q <= valid[STAGES-1:0];
          data_q[at_q] <= data_i;
          at_q <= at_q == LAST[AT_BITS-1:0] ? {AT_BITS{1'b0}} : at_q + 1'b1;
        end
      assign valid_o = valid[STAGES];
      assign data_o = data_q[at_q];
    end
  endgenerate
endmodule
";
