// tools/read_back.h: a copy of a store, read from the disk and compared with what was copied.
#pragma once

#include <filesystem>
#include <string>

#include "plait/store.h"

namespace plait {

/// The digest of `store`, with a progress bar that calls the work `task`. Errors: as digest().
std::string digest_with_progress(Store& store, std::string task, int threads);

/// Opens the copy as any reader would, past what the page cache has of it, and compares its digest
/// with that of `source`: all vertices of all attributes, whatever keeps them. Returns the digest.
/// REQUIRES: the copy was committed. Errors: kCorruption if the digests differ; as Store::open and
/// digest().
std::string compare_copy(Store& source, const std::filesystem::path& copy, const OpenOptions& open,
                         int threads, const BackendRegistry& backends);

}  // namespace plait
