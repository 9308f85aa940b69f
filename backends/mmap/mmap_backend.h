// backends/mmap/mmap_backend.h: a level as a mapped file of raw bytes. The file is the same as with
// pread, byte for byte.
//
// Only a level that was opened for reading is mapped. For a level that is written, the pager uses
// frames as with pread. Writing through a mapping has three faults. With several threads, half of
// the time goes into TLB shootdowns: the kernel tells every processor that a page may no longer be
// written. A full disk kills the process (SIGBUS). And a stray pointer can change the store.
#pragma once

#include <memory>

#include "plait/extend/backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr BackendTraits kMmapTraits{
    .durable = true, .maps_for_reading = true, .overwrites_in_place = true};

/// Errors: as open_fixed_file; kIo if the file cannot be mapped.
std::unique_ptr<Backend> open_mmap_backend(const LevelSpec& level);

PLAIT_END_NAMESPACE
