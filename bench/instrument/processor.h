// bench/instrument/processor.h: which processor measurements are made on.
#pragma once

#include <string>

namespace plait::instrument {

/// "Intel(R) Xeon(R) Processor @ 2.80GHz": the model name of the first processor in /proc/cpuinfo.
/// Empty if the kernel does not tell it, as on most machines that are not x86.
std::string processor_name();

}  // namespace plait::instrument
