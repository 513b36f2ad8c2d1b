// Finds the word that the user may have meant.
#pragma once

#include <string>
#include <vector>

namespace tress::inline v0_2 {

/// The number of insertions, deletions, replacements and swaps of neighbours that turn a into b.
int edit_distance(const std::string& a, const std::string& b);
/// Returns the candidate at the smallest edit distance; the first of equals; empty if there are no candidates.
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace tress::inline v0_2
