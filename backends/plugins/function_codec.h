// backends/plugins/function_codec.h: codecs and filters that are C functions of a plug-in.
#pragma once

#include "plait/detail/namespace.h"
#include "plait/extend/pipeline_registry.h"
#include "plait/extend/plugin.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Entries that call the functions. They copy the structures and the texts. Errors:
/// kInvalidArgument for a structure of another size, and for a missing function or text.
RegisteredCodec entry_of(const plait_codec* codec);
RegisteredFilter entry_of(const plait_filter* filter);

PLAIT_END_NAMESPACE
