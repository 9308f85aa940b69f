#include "measure.h"

namespace plait {
namespace {

/// Constructed before main() begins. The time of the loader before that is a few milliseconds.
const Stopwatch kSinceStart;

}  // namespace

double seconds_since_start() { return kSinceStart.seconds(); }

}  // namespace plait
