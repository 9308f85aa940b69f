#include "tune/disk_model.h"

#include <algorithm>

namespace plait::tune {
namespace {

constexpr double kMega = 1e6, kGiga = 1e9;

}  // namespace

std::vector<Disk> classes_of_disks() {
  return {{"network, 100 MB/s", 100 * kMega, 100 * kMega, 1e-3, 100 * kMega, 0, false},
          {"SATA, 500 MB/s", 500 * kMega, 500 * kMega, 1e-4, 500 * kMega, 0, false},
          {"NVMe, 3 GB/s", 3 * kGiga, 3 * kGiga, 8e-5, 3 * kGiga, 0, false},
          {"memory, 10 GB/s", 10 * kGiga, 10 * kGiga, 0, 10 * kGiga, 0, false}};
}

Predicted predict(const std::vector<Work>& attributes, const Disk& disk, double processors) {
  Predicted predicted;
  predicted.update = 0;
  double stored = 0, encode = 0;
  for (const Work& work : attributes) {
    // Levels are read one after another, and the blocks ahead while a block is decoded.
    const double decode = work.decode_seconds / processors;
    const double read = work.stored_bytes / disk.read;
    predicted.read += std::max(read, decode);
    predicted.patch +=
        disk.latency + work.block_stored_bytes / disk.random_read + work.block_decode_seconds;
    if (work.is_fixed)
      predicted.update.reset();
    else if (predicted.update)
      *predicted.update += std::max(read + work.stored_bytes / disk.write,
                                    decode + work.encode_seconds / processors);
    stored += work.stored_bytes;
    encode += work.encode_seconds / processors;
  }
  // The disk begins when the system has as many bytes as it holds back.
  const double alone = stored > 0 ? encode * std::min(1.0, disk.unwritten_bytes / stored) : encode;
  predicted.write = alone + std::max(encode - alone, stored / disk.write);
  return predicted;
}

}  // namespace plait::tune
