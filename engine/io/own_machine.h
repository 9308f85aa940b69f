// io/own_machine.h: the name of this machine in names of files, so that no machine takes the
// unfinished work of another one for its own.
#pragma once

#include <string>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Processes with the same two see each other's locks (flock), also from different containers. The
/// name of the host alone does not say that: on many file systems two machines of one name, as
/// containers often have, do not see each other's locks.
struct OwnMachine {
  std::string host;   ///< at most 32 characters of [A-Za-z0-9_.]
  std::string start;  ///< of its kernel, 8 characters; random if the system does not tell it
};
const OwnMachine& own_machine();

/// 8 hexadecimal digits.
std::string random_hex();

PLAIT_END_NAMESPACE
