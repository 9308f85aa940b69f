#include "tune/disk_model.h"

#include <algorithm>
#include <cmath>

namespace plait::tune {
namespace {

constexpr double kMega = 1e6, kGiga = 1e9;

}  // namespace

std::vector<Disk> classes_of_disks() {
  return {{"network, 100 MB/s", 100 * kMega, 100 * kMega, 1e-3, 100 * kMega, 0, {}, false},
          {"SATA, 500 MB/s", 500 * kMega, 500 * kMega, 1e-4, 500 * kMega, 0, {}, false},
          {"NVMe, 3 GB/s", 3 * kGiga, 3 * kGiga, 8e-5, 3 * kGiga, 0, {}, false},
          {"memory, 10 GB/s", 10 * kGiga, 10 * kGiga, 0, 10 * kGiga, 0, {}, false}};
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

double modelled_read(const Work& work, const Machine& machine) {
  // Levels are read one after another, and the blocks ahead while a block is decoded.
  const double disk = work.stored_bytes / rate_of(machine.disk, work.block_stored_bytes).read;
  const double decode = work.decode_seconds / machine.processors;
  return machine.reading.factor *
         (std::max(disk, decode) + machine.reading.added * std::min(disk, decode));
}

Predicted predict(const std::vector<Work>& attributes, const Machine& machine) {
  const Disk& disk = machine.disk;
  const double processors = machine.processors;
  Predicted predicted;
  predicted.update = 0;
  double stored = 0, encode = 0, write = 0;
  for (const Work& work : attributes) {
    const double decode = work.decode_seconds / processors;
    const BlockRate rate = rate_of(disk, work.block_stored_bytes);
    const double read = work.stored_bytes / rate.read;
    predicted.read += modelled_read(work, machine) * (disk.is_measured ? work.read_factor : 1.0);
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
