// tools/tune/figures.h: what was measured of a pipeline, and how sure it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "plait/attribute.h"

namespace plait::tune {

/// A figure and the interval that the true one is in, with a confidence of 95 %.
struct Figure {
  double value = 0, low = 0, high = 0;
};
inline bool overlap(const Figure& a, const Figure& b) { return a.low <= b.high && b.low <= a.high; }

/// One pipeline on one part of the sample. Times are processor time of one thread.
struct Outcome {
  double raw_bytes = 0, stored_bytes = 0;
  double encode_seconds = 0, decode_seconds = 0;  ///< the shortest of all visits
  int visits = 0;                                 ///< 0: not measured
};

/// One pipeline for one attribute, with one block size.
struct Trial {
  std::size_t attribute = 0;  ///< in Trials::attributes
  std::uint64_t block_bytes = 0;
  std::string pipeline;
  double finest_block_bytes = 0;  ///< raw bytes of a block of the finest level
  /// So levels become fixed (docs/compression.md).
  bool needs_other_blocks = false;
  std::vector<Outcome> outcomes;  ///< [part of the attribute's sample]
  /// With the stage `predicted`. A block that changes in place is no longer predicted.
  bool is_predicted = false;
};

/// An attribute of the store, all its levels together.
struct SampledAttribute {
  AttributeSchema schema;
  double raw_bytes = 0;   ///< of all levels
  std::size_t parts = 0;  ///< of the sample
  bool is_whole = false;  ///< the sample is the whole attribute
};

/// By how much the reads of a choice that was stored on the measured disk differed from the model.
struct ReadCorrection {
  std::uint64_t block_bytes = 0;
  std::vector<std::size_t> trials;  ///< [attribute] in Trials::trials
  bool stores_raw = false;          ///< as they are, with another backend
  std::vector<double> factors;      ///< [attribute] measured / modelled
};

/// All that was measured.
struct Trials {
  std::vector<SampledAttribute> attributes;
  std::vector<Trial> trials;
  std::vector<ReadCorrection> corrections = {};
};

/// What a pipeline needs for each raw byte. REQUIRES: the trial was measured on a part.
struct Rates {
  Figure stored;          ///< bytes
  Figure encode, decode;  ///< seconds
};
/// Of the parts on which all trials of the attribute were measured, so that all have seen the same
/// bytes; of those on which this trial was measured, if there are none. `without` leaves one of
/// them out, by its place among common_parts(), unless it is the only one.
Rates rates_of(const Trials& trials, const Trial& trial, std::optional<std::size_t> without = {});
bool is_measured(const Trial& trial);

/// sum(y) / sum(x), if pairs (x, y) are a random part of a whole. With `is_whole` the interval is
/// only the value. W. G. Cochran, Sampling Techniques, 1977, (6.13). Here and below, fewer than two
/// pairs tell nothing of the spread: then the interval is everything. Pinned by
/// tests/tools/tune/figures_test.cpp.
Figure ratio_of_sums(const std::vector<double>& x, const std::vector<double>& y, bool is_whole);
/// The same for pairs that were chosen with a chance in proportion to x: the mean of y / x. The
/// same book, (9A.2). Pinned by the same test.
Figure mean_of_ratios(const std::vector<double>& x, const std::vector<double>& y);

/// The parts on which all trials of the attribute were measured.
std::vector<std::size_t> common_parts(const Trials& trials, std::size_t attribute);

}  // namespace plait::tune
