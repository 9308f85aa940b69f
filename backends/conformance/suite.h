// backends/conformance/suite.h: the specification of a backend, as checks that are run over every
// one. A new backend is done when it passes. The program plait-conformance runs the suite on a
// backend of anybody's; the tests of the project run it on the built-in ones.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "conformance/check_log.h"
#include "conformance/level.h"
#include "plait/error.h"

namespace plait::conformance {

/// A promise of plait/extend/backend.h, and the check that it is kept.
struct Promise {
  std::string_view name;  ///< "read-never-written"
  std::string_view text;  ///< the promise: one sentence
  /// Whether a backend with these traits gives the promise.
  bool (*concerns)(const BackendTraits& traits);
  void (*check)(const Subject& subject, CheckLog& log);
};

/// All promises, in the order in which a backend is written.
std::span<const Promise> promises();

/// Checks one promise. An exception of the backend is a finding.
CheckLog check(const Promise& promise, const Subject& subject);

/// The code of the Error that `call` throws, or nothing if it returns. A message that is not one
/// line is a finding.
template <class Call>
std::optional<ErrorCode> error_of(CheckLog& log, const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    log.expect(std::string_view(error.what()).find('\n') == std::string_view::npos,
               "the message of an error is one line");
    return error.code();
  }
  return std::nullopt;
}

// The checks, by the part of the interface that they are about.
void check_entry(const Subject& subject, CheckLog& log);
void check_never_written(const Subject& subject, CheckLog& log);
void check_shapes(const Subject& subject, CheckLog& log);
void check_overwriting(const Subject& subject, CheckLog& log);
void check_bounds(const Subject& subject, CheckLog& log);
void check_table_size(const Subject& subject, CheckLog& log);
void check_advice(const Subject& subject, CheckLog& log);
void check_threads(const Subject& subject, CheckLog& log);
void check_context(const Subject& subject, CheckLog& log);

void check_codec_gives_back(const Subject& subject, CheckLog& log);
void check_codec_is_repeatable(const Subject& subject, CheckLog& log);
void check_codec_stays_inside(const Subject& subject, CheckLog& log);

void check_address_in_memory(const Subject& subject, CheckLog& log);
void check_address_mapped(const Subject& subject, CheckLog& log);

void check_transfers(const Subject& subject, CheckLog& log);
void check_damaged_transfer(const Subject& subject, CheckLog& log);

void check_reopening(const Subject& subject, CheckLog& log);
void check_modes(const Subject& subject, CheckLog& log);
void check_read_only(const Subject& subject, CheckLog& log);
void check_flipped_bit(const Subject& subject, CheckLog& log);
void check_swapped_blocks(const Subject& subject, CheckLog& log);
void check_file_cut_short(const Subject& subject, CheckLog& log);
void check_file_cut_while_open(const Subject& subject, CheckLog& log);
void check_failed_write(const Subject& subject, CheckLog& log);
void check_bad_entries(const Subject& subject, CheckLog& log);
void check_shared_file(const Subject& subject, CheckLog& log);

}  // namespace plait::conformance
