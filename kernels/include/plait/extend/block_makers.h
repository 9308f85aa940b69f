// plait/extend/block_makers.h: makes the blocks of levels of a one-ring scheme again from the base
// mesh (plait/extend/block_maker.h).
//
// A recipe is SCHEME/OUTPUT/PRECISION/LEVELS, such as "loop/position/float32/5". OUTPUT is
// position, limit or normal. LEVELS is how often the base mesh was refined in all: Loop's coarse
// vertices move with each finer level, and normals belong to the finest mesh.
//
// Any block depends on the faces at its edges and on their neighbours only. So its maker refines
// these faces from the base mesh to the level of the block, sixteen at once, with the rows of the
// fused executor. From there it takes each vertex with its ring to the finest level: the ring of a
// vertex at one level depends only on its ring at the coarser level. The bits are those of every
// executor. Pinned by tests/kernels/predicted_test.cpp.
#pragma once

#include <memory>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/detail/one_ring.h"
#include "plait/extend/block_maker.h"

PLAIT_BEGIN_NAMESPACE

/// Levels finer than this, counted from the base mesh, are not predicted: a face with all its
/// points would need too much memory.
inline constexpr int kMostMadeLevels = 8;

/// Makers of the library's one-ring schemes, and of a program's own. (Butterfly reads two rings;
/// its levels are not predicted.) A mesh with a vertex of 256 faces or more is not predicted
/// either. A program that has rules of its own passes the result to
/// PipelineRegistry::set_block_makers().
std::shared_ptr<const BlockMakers> subdivision_block_makers(
    std::vector<OneRingScheme> own_schemes = {});

PLAIT_END_NAMESPACE
