// An attribute of a store that is computed when it is read (plait/derivation.h): its rule, the
// connection to its source, its levels and its base records.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/backend.h"
#include "plait/derivation.h"
#include "plait/level_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Any number of threads may call the const functions. The object does not move: its levels refer
/// to it.
class DerivedAttribute {
 public:
  /// `schema` may have another name than the attribute. Errors: those of Derivations::source_of().
  DerivedAttribute(std::shared_ptr<const Derivations> rules, std::string derivation,
                   AttributeSchema schema);
  DerivedAttribute(const DerivedAttribute&) = delete;
  DerivedAttribute& operator=(const DerivedAttribute&) = delete;

  const std::string& derivation() const { return derivation_; }
  const std::string& source() const { return source_; }

  /// Computes records from this source from now on. Errors: those of Derivations::open().
  void connect(DerivationSource source);
  /// Computes nothing; reading fails with kBadState and this reason.
  void disconnect(std::string reason);
  /// Why the attribute cannot be read; empty if it can.
  const std::string& refusal() const { return refusal_; }
  std::uint64_t scratch_bytes() const { return deriver_ ? deriver_->scratch_bytes() : 0; }

  /// The backend of one level. `geometry` and this object outlive it.
  std::unique_ptr<Backend> open_level(const LevelGeometry& geometry, std::string name) const;
  /// The records of the base vertices, which the first call computes. They stay valid until they
  /// are computed anew, after a change of the source. Errors: kBadState without a source; those of
  /// Session::pin.
  std::span<const std::byte> base_records() const;
  /// The next call of base_records() computes them anew.
  void source_base_changed() noexcept { ++changes_; }

  /// Errors: kBadState without a source.
  const Deriver& deriver() const;

 private:
  std::shared_ptr<const Derivations> rules_;
  std::string derivation_;
  AttributeSchema schema_;
  std::string source_;
  std::unique_ptr<Deriver> deriver_;
  std::string refusal_;
  std::size_t base_bytes_ = 0;
  std::vector<const LevelFile*> source_levels_;
  std::atomic<std::uint64_t> changes_ = 0;
  mutable std::mutex base_mutex_;
  mutable std::vector<std::byte> base_;
  mutable std::uint64_t base_state_ = 0;
  mutable bool has_base_ = false;
};

PLAIT_END_NAMESPACE
