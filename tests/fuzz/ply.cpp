// A PLY file, plain or compressed, and the base mesh that it gives.
#include "mesh/files/readers.h"
#include "mesh_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  plait::fuzz::check_reader(plait::read_ply, data, size);
  return 0;
}
