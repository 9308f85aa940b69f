// generate/molecule_chain.h: atoms folded into something like a small protein.
#pragma once

#include <cstdint>
#include <vector>

#include "generate/random.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {

struct Atom {
  Vector3<double> centre;  ///< angstrom
  double radius;           ///< van der Waals, angstrom
};

/// `count` atoms: compact self-avoiding chains of backbone atoms 3.8 angstrom apart, each with up
/// to eight atoms of a side chain. Consecutive backbone atoms overlap, and a new chain begins in
/// touch with the chains before it.
std::vector<Atom> fold_chain(std::uint64_t count, Random& random);

}  // namespace generation
PLAIT_END_NAMESPACE
