// Clustered principal component analysis of transfer: Sloan, Hall, Hart and Snyder, "Clustered Principal Components for
// Precomputed Radiance Transfer" (2003).
#pragma once

#include <alpenglow/prt/transfer_table.hpp>

namespace alpenglow::prt {

struct CpcaSettings {
    std::size_t clusters = 64;
    std::size_t components = 8; // weights a point, one byte each
    int iterations = 12;        // of assignment by reconstruction error and refitting
    unsigned threads = 0;       // the result is the same for any number
};

// Encodes a field (vectors or small matrices) as CPCA. Points are reordered by cluster, each cluster padded to blocks
// of 16; evaluation writes them back in their own order. info.encoding_rms says what it cost.
[[nodiscard]] Result<TransferTable> encode_cpca(const TransferField& field, const CpcaSettings& settings);

// The fewest components (1 .. most) that keep the relative RMS error below max_error, with clusters by the field's
// size. An Error if `most` components do not reach it.
[[nodiscard]] Result<TransferTable> encode_cpca_within(const TransferField& field, double max_error,
                                                       std::size_t most = 24, unsigned threads = 0);

} // namespace alpenglow::prt
