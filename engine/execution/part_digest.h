// The digest of what one part of a store has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>

#include "plait/digest.h"
#include "plait/extend/topology.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The sum of the hashes of the slots of a part's store (store/parts/part_store.h), and of these
/// base vertices, for these attributes. The sum of all parts and all attributes is the digest of
/// the whole store. Errors: as digest().
Digest digest_of_part(const Store& store, std::span<const VertexId> vertices,
                      std::span<const AttributeId> attributes,
                      const ProgressCallback& progress = {});

/// The same for a part whose levels a fused pass makes, without reading them again: the pass hands
/// over each block that it has filled, while the block is in the cache. There is one object for a
/// store at once. Threads: one makes and ends it (docs/threads.md); those of the pass work on it.
class FilledDigest {
 public:
  /// The store stays open as long as the object lives.
  explicit FilledDigest(Store& store);
  ~FilledDigest();
  FilledDigest(const FilledDigest&) = delete;
  FilledDigest& operator=(const FilledDigest&) = delete;

  /// With these base vertices of all attributes. REQUIRES: one fused pass has ended, which made all
  /// levels of all attributes.
  Digest with_base_vertices(std::span<const VertexId> vertices) const;

 private:
  void add(AttributeId attribute, int level, std::uint64_t block, std::span<const std::byte> bytes);

  Store& store_;
  std::mutex mutex_;
  Digest sum_;
};

/// a + b modulo 2^128.
Digest sum_of(const Digest& a, const Digest& b);

PLAIT_END_NAMESPACE
