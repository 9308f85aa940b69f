// bench/peers/compression_ways.h: the ways in which the measurement of compression encodes and
// decodes the blocks of an attribute. Each way adds to the sizes and times that it gets, and checks
// that the raw bytes come back. Times are processor time of this thread.
#pragma once

#include <string>

#include "peers/compression_peers.h"
#include "peers/compression_surfaces.h"

namespace plait::bench {

struct Sizes {
  double raw = 0, stored = 0, entropy = 0;  ///< bytes
};
struct Times {
  double encode = 0, decode = 0;  ///< seconds
};

/// A pipeline or the name of a preset. The codec `none` stands for the filters alone. Of a pipeline
/// whose last filter is `shuffle`, also the entropy of the filtered bytes. Errors: as
/// PipelineRegistry::make; kCorruption if other bytes come back.
void run_pipeline(const MeasuredAttribute& attribute, const std::string& name, Sizes& sizes,
                  Times& times);
/// Blocks that the scheme makes again: encoding compares a block with what is made, decoding makes
/// it. An entry of the block table is all that is stored. Errors: kCorruption if a block is not
/// what the scheme makes.
void run_predicted(const MeasuredAttribute& attribute, Sizes& sizes, Times& times);
/// Errors: kCorruption if other bytes come back.
void run_peer(const MeasuredAttribute& attribute, const CompressionPeer& peer, Sizes& sizes,
              Times& times);
/// memcpy there and back, the floor.
void run_copies(const MeasuredAttribute& attribute, Sizes& sizes, Times& times);

}  // namespace plait::bench
