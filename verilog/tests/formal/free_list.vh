// What holds inside the free list, without which no induction starts from a state that is reached:
// each section is in exactly one of three places, it was never used, or it is in the queue, or out.
//
// `words.vh` declares `words`, the queue's memory. A `hierconn` wire becomes the one of its name
// below `list` when the hierarchy is flattened.
localparam COUNT_BITS = $clog2(N + 1);
(* hierconn *) wire [COUNT_BITS-1:0] \list.fresh_q ;
(* hierconn *) wire [ID_BITS-1:0] \list.u_queue.head_q ;
(* hierconn *) wire [ID_BITS-1:0] \list.u_queue.tail_q ;
(* hierconn *) wire [COUNT_BITS-1:0] \list.u_queue.count_q ;
(* hierconn *) wire [ID_BITS-1:0] \list.u_queue.memory_data ;
`include "words.vh"

// Numbers that no sum below overflows.
wire [7:0] fresh = \list.fresh_q ;
wire [7:0] head = \list.u_queue.head_q ;
wire [7:0] tail = \list.u_queue.tail_q ;
wire [7:0] count = \list.u_queue.count_q ;

// The words that are in the queue: `count` of them from the head on.
wire [N-1:0] queued, queued_in_range;
// How many places each section is in.
wire [8*N-1:0] places;
genvar k, id;
generate
  for (k = 0; k < N; k = k + 1) begin : word
    assign queued[k] = (k >= head ? k - head : k + N - head) < count;
    assign queued_in_range[k] = !queued[k] || words[k*ID_BITS +: ID_BITS] < N;
  end
  for (id = 0; id < N; id = id + 1) begin : section
    reg [7:0] sum;
    integer at;
    always @* begin
      sum = (id >= fresh) + out[id];
      for (at = 0; at < N; at = at + 1)
        sum = sum + (queued[at] && words[at*ID_BITS +: ID_BITS] == id);
    end
    assign places[8*id +: 8] = sum;
  end
endgenerate

always @*
  if (started) begin
    registers_in_range: assert (fresh <= N && head < N && tail < N && count <= N);
    tail_follows: assert (tail == (head + count >= N ? head + count - N : head + count));
    words_in_range: assert (&queued_in_range);
    in_one_place: assert (places == {N{8'd1}});
    if (count != 0) head_is_shown:
      assert (\list.u_queue.memory_data == words[head*ID_BITS +: ID_BITS]);
  end
