// plait/create_store.h: makes and opens stores with the built-in backends. For backends of your
// own: Store::create(), Store::open() and plait/registry.h.
#pragma once

#include <filesystem>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/options.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Makes a new store of `mesh`, in the order that lay_out() chooses, with the attribute "position"
/// of float32: ready for subdivide(). For another order, float64 positions or none: Store::create()
/// and add_base_positions(). Errors: of lay_out(), Store::create() and add_base_positions().
Store create_store(const std::filesystem::path& path, const BaseMesh& mesh,
                   const StoreOptions& options = {});

/// Store::open() with default_backends().
Store open_store(const std::filesystem::path& path, const OpenOptions& options = {});

PLAIT_END_NAMESPACE
