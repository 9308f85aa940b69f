#include "tune/disk_model.h"

#include <algorithm>
#include <cmath>

namespace plait::tune {
namespace {

constexpr double kMega = 1e6, kGiga = 1e9;

}  // namespace

std::vector<Disk> classes_of_disks() {
  const auto disk = [](const char* name, double rate, double latency) {
    return Disk{.name = name, .read = rate, .write = rate, .latency = latency, .random_read = rate};
  };
  return {disk("network, 100 MB/s", 100 * kMega, 1e-3), disk("SATA, 500 MB/s", 500 * kMega, 1e-4),
          disk("NVMe, 3 GB/s", 3 * kGiga, 8e-5), disk("memory, 10 GB/s", 10 * kGiga, 0)};
}

BlockRate rate_of(const Disk& disk, double block_bytes) {
  const auto& rates = disk.of_blocks;
  if (rates.empty()) return {block_bytes, disk.read, disk.write};
  const auto next = std::ranges::lower_bound(rates, block_bytes, {}, &BlockRate::block_bytes);
  if (next == rates.begin()) return rates.front();
  if (next == rates.end()) return rates.back();
  const BlockRate &a = *(next - 1), &b = *next;
  const double part =
      std::log(block_bytes / a.block_bytes) / std::log(b.block_bytes / a.block_bytes);
  return {block_bytes, a.read + part * (b.read - a.read), a.write + part * (b.write - a.write)};
}

double seconds_to_read(const Disk& disk, double block_bytes, double before, double bytes) {
  const double rate = rate_of(disk, block_bytes).read;
  if (!(disk.burst_bytes > 0)) return bytes / rate;
  const auto until = [&](double at) {
    return std::max(at / disk.burst_read, (at - disk.burst_bytes) / rate);
  };
  return until(before + bytes) - until(before);
}

Burst burst_of(double bytes, double first_sixteenth_seconds, double first_half_seconds,
               double second_half_seconds) {
  const double half = bytes / 2;
  if (!(first_half_seconds > 0) || first_half_seconds > 0.75 * second_half_seconds) return {};
  const double lasting = half / second_half_seconds;
  const double first = std::min(first_sixteenth_seconds, first_half_seconds / 8);
  return {half - lasting * first_half_seconds,
          first > 0 ? bytes / 16 / first : half / first_half_seconds};
}

std::vector<double> modelled_reads(const std::vector<Work>& attributes, const Machine& machine) {
  std::vector<double> reads;
  double before = 0;
  for (const Work& work : attributes) {
    // Levels are read one after another, and the blocks ahead while a block is decoded.
    const double disk =
        seconds_to_read(machine.disk, work.block_stored_bytes, before, work.stored_bytes);
    const double decode = work.decode_seconds / machine.processors;
    reads.push_back(machine.reading.factor *
                    (std::max(disk, decode) + machine.reading.added * std::min(disk, decode)));
    before += work.stored_bytes;
  }
  return reads;
}

Predicted predict(const std::vector<Work>& attributes, const Machine& machine) {
  const Disk& disk = machine.disk;
  const double processors = machine.processors;
  Predicted predicted;
  predicted.update = 0;
  double stored = 0, encode = 0, write = 0;
  const std::vector<double> reads = modelled_reads(attributes, machine);
  for (std::size_t id = 0; id < attributes.size(); ++id) {
    const Work& work = attributes[id];
    const double decode = work.decode_seconds / processors;
    const BlockRate rate = rate_of(disk, work.block_stored_bytes);
    const double read = work.stored_bytes / rate.read;
    predicted.read += reads[id] * (disk.is_measured ? work.read_factor : 1.0);
    predicted.patch +=
        disk.latency + work.block_stored_bytes / disk.random_read + work.block_decode_seconds;
    if (work.is_fixed)
      predicted.update.reset();
    else if (predicted.update)
      *predicted.update += std::max(read + work.stored_bytes / rate.write,
                                    decode + work.encode_seconds / processors);
    stored += work.stored_bytes;
    write += work.stored_bytes / rate.write;
    encode += work.encode_seconds / processors;
  }
  // The disk begins when the system has as many bytes as it holds back.
  const double alone = stored > 0 ? encode * std::min(1.0, disk.unwritten_bytes / stored) : encode;
  predicted.write = alone + std::max(encode - alone, write);
  return predicted;
}

}  // namespace plait::tune
