// The contract of a section allocator, as properties of its ports; see hw/src/allocator/mod.rs.
//
// `out` follows which sections are out: granted and not yet released. Nothing is asserted before
// the first reset, and nothing is assumed but that a section that is released is out. A reset may
// come at any time, and with `en_i` low take and release are without effect.
module contract (
  input clk,
  input rst,
  input en_i,
  input take_i,
  input release_valid_i,
  input [ID_BITS-1:0] release_payload_i
);
  localparam N = `SECTIONS;
  localparam ID_BITS = N > 2 ? $clog2(N) : 1;

  wire grant_valid, exhausted;
  wire [ID_BITS-1:0] grant_payload;
  free_list list (
    .clk(clk),
    .rst(rst),
    .en_i(en_i),
    .take_i(take_i),
    .release_valid_i(release_valid_i),
    .release_payload_i(release_payload_i),
    .grant_valid_o(grant_valid),
    .grant_payload_o(grant_payload),
    .exhausted_o(exhausted)
  );

  // The sections that are out, and that there was a reset.
  reg [N-1:0] out;
  reg started = 1'b0;
  wire granted = en_i && take_i && grant_valid;
  wire released = en_i && release_valid_i;
  always @(posedge clk)
    if (rst) begin
      out <= {N{1'b0}};
      started <= 1'b1;
    end else begin
      if (released) out[release_payload_i] <= 1'b0;
      if (granted) out[grant_payload] <= 1'b1;
    end

  always @*
    if (started && !rst && released) assume (release_payload_i < N && out[release_payload_i]);

  // What was offered in the cycle before and must still be.
  reg held = 1'b0;
  reg [ID_BITS-1:0] offered;
  always @(posedge clk) begin
    held <= started && !rst && grant_valid && !granted;
    offered <= grant_payload;
  end

  always @*
    if (started) begin
      if (grant_valid) in_range: assert (grant_payload < N);
      if (grant_valid) not_twice: assert (!out[grant_payload]);
      none_lost: assert (grant_valid == !(&out));
      exhausted_tells: assert (exhausted == &out);
      if (held) stays_offered: assert (grant_valid && grant_payload == offered);
    end

`ifdef INSIDE
`include "inside.vh"
`endif

  // All sections were out, one came back, and it was granted again; then the same after a reset.
  reg [1:0] turn = 2'd0;
  reg again = 1'b0;
  always @(posedge clk)
    if (rst) begin
      turn <= 2'd0;
      again <= again || turn == 2'd3;
    end else if (turn == 2'd0 && started && &out) turn <= 2'd1;
    else if (turn == 2'd1 && released) turn <= 2'd2;
    else if (turn == 2'd2 && granted) turn <= 2'd3;
  always @* all_went_round: cover (turn == 2'd3 && again);
endmodule
