// Plays a frame to the machine that Verilator built, as the Rust bench does: a fragment is offered until
// it is taken, after the last one comes the end mark, then nothing until every pixel has been shown. To a
// machine that REPLAYS the frame is sent as often as it asks for it.
//
//   machine FRAME PIXELS
//
// FRAME is a file of fragments of four native words: x, y, z, rgba. Every line of the standard input plays
// the frame once from reset and is the path of that frame's waveform, which only a machine that was
// built with --trace or --trace-fst writes. Each is answered by a line: cycles, seconds, checksum of the image.
#include "Vmachine.h"
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>
#if VM_TRACE_FST
#include "verilated_fst_c.h"
using WaveFile = VerilatedFstC;
#elif VM_TRACE
#include "verilated_vcd_c.h"
using WaveFile = VerilatedVcdC;
#endif

struct Fragment {
  uint32_t x, y, z, rgba;
};

// The waveform of a frame, after every evaluation from the first on in which the machine is no longer clearing
// its memories, as the Rust simulation has it; times go on from frame to frame.
class Wave {
#if VM_TRACE
  WaveFile file;
  bool begun = false;
  static inline uint64_t time_ns = 0;

public:
  Wave(Vmachine& machine, const std::string& path) {
    machine.trace(&file, 99);
    file.open(path.c_str());
  }
  void show(const Vmachine& machine) {
    begun = begun || machine.phase_o != 0;
    if (begun) file.dump(time_ns += 5);
  }
  void finish() { file.close(); }
#else
public:
  Wave(Vmachine&, const std::string&) {}
  void show(const Vmachine&) {}
  void finish() {}
#endif
};

// FNV-1a over whole words.
class Checksum {
  uint64_t sum = 0xcbf29ce484222325;

public:
  void add(uint32_t pixel) { sum = (sum ^ pixel) * 0x100000001b3; }
  uint64_t get() const { return sum; }
};

// Whether the frame is to come once more.
static bool replay([[maybe_unused]] const Vmachine& machine) {
#if REPLAYS
  return machine.replay_o;
#else
  return false;
#endif
}

static void edge(Vmachine& machine, Wave& wave) {
  machine.clk = 1;
  machine.eval();
  wave.show(machine);
}

static void settle(Vmachine& machine, Wave& wave) {
  machine.clk = 0;
  machine.eval();
  wave.show(machine);
}

static void play(Vmachine& machine, const std::vector<Fragment>& frame, uint64_t pixels,
                 const std::string& path) {
  Checksum checksum;
  uint64_t cycles = 0;
  const auto start = std::chrono::steady_clock::now();
  Wave wave(machine, path);
  machine.en_i = 1;
  machine.image_ready_i = 1;
  machine.fragment_valid_i = 0;
  machine.rst = 1;
  settle(machine, wave);
  edge(machine, wave);
  machine.rst = 0;
  size_t sent = 0;
  // All was sent, and it is not known yet whether it is asked for again.
  bool waits = false;
  for (; pixels > 0; cycles++) {
    const bool item = !waits && sent < frame.size();
    const bool end = !waits && sent == frame.size();
    if (item) {
      machine.fragment_payload_item_x_i = frame[sent].x;
      machine.fragment_payload_item_y_i = frame[sent].y;
      machine.fragment_payload_item_z_i = frame[sent].z;
      machine.fragment_payload_item_rgba_i = frame[sent].rgba;
    }
    machine.fragment_payload_end_i = end;
    machine.fragment_valid_i = item || end;
    settle(machine, wave);
    if (machine.fragment_ready_o && waits) {
      waits = false;
      if (replay(machine)) sent = 0;
    } else if (machine.fragment_ready_o && (item || end)) {
      sent++;
      waits = REPLAYS && end;
    }
    if (machine.image_valid_o && machine.image_ready_o) {
      checksum.add(machine.image_payload_o);
      pixels--;
    }
    edge(machine, wave);
  }
  wave.finish();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  std::printf("%" PRIu64 " %.9f %" PRIu64 "\n", cycles, took.count(), checksum.get());
  std::fflush(stdout);
}

int main(int, char** argv) {
  std::ifstream file(argv[1], std::ios::binary);
  std::vector<Fragment> frame;
  for (Fragment next; file.read(reinterpret_cast<char*>(&next), sizeof next);) frame.push_back(next);
  const uint64_t pixels = std::strtoull(argv[2], nullptr, 10);
#if VM_TRACE
  Verilated::traceEverOn(true);
#endif
  Vmachine machine;
  for (std::string path; std::getline(std::cin, path);) play(machine, frame, pixels, path);
}
