// backends/mmap/mmap_backend.h: a level as a mapped file of raw bytes. The file is that of pread,
// byte for byte.
//
// Only a level that was opened for reading is mapped. One that is written goes through frames as
// with pread: storing through a mapping from several threads spends half of the time in telling
// every processor that a page may no longer be written, a full disk is a SIGBUS there, and a stray
// pointer changes the store.
#pragma once

#include <memory>

#include "plait/backend.h"

namespace plait {

constexpr BackendTraits kMmapTraits{
    .durable = true, .maps_for_reading = true, .overwrites_in_place = true};

/// Errors: as open_fixed_file; kIo if the file cannot be mapped.
std::unique_ptr<Backend> open_mmap_backend(const LevelSpec& level);

}  // namespace plait
