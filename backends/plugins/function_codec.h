// backends/plugins/function_codec.h: codecs and filters that are C functions of a plug-in.
#pragma once

#include "plait/backends/pipeline.h"
#include "plait/namespace.h"
#include "plait/plugin.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Entries that call the functions. They copy the structures and the texts. Errors:
/// kInvalidArgument for a structure of another size, and for a missing function or text.
PipelineRegistry::CodecEntry entry_of(const plait_codec* codec);
PipelineRegistry::FilterEntry entry_of(const plait_filter* filter);

PLAIT_END_NAMESPACE
