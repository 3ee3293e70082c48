// The tree search of fatigue_planner/planners/pomcp/search.py written by hand in C++17, as a yardstick of speed.
//
// The same algorithm: no rollout, UCB1 with untried actions first in order and equal scores to the first,
// Eq. 4's choice, backup by mean or by max (MaxUCT). Only the random stream is another one (xoshiro256+).
//
// What makes it fast:
// - a node is one record (64 bytes with two actions and two observations: one cache line), laid out as
//   wanted by the descent; nodes are initialised when they are made, in memory that stays between calls;
// - UCB1 without division, root or logarithm: tables of sqrt(log N), 1 / sqrt(n) and 1 / n;
//   1 / sqrt(0) = inf makes the untried action win without a branch;
// - the state is simulated again in each descent (not kept in the nodes), in vectors of eight entries which
//   stay in registers where the number of entries is a template argument;
// - a node's next action is chosen when a return is backed up: a descent need not wait for the scores;
// - where a node's state is always the same and so is the worker's choice (one initial state, an expert), the node
//   keeps the choice and its successor the reward: the state is simulated only where a descent leaves the tree;
// - among 2, 4, ... equally likely preferences a choice takes one bit, two bits, ... of a random number;
// - the max backup is a mean backup of another target: r + gamma (n V - n' V'), with the successor's visits
//   and value after (n, V) and before (n', V') this descent, so that no other successor is looked at.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <new>
#include <vector>

namespace {

constexpr int LANES = 8;
typedef double Lanes __attribute__((vector_size(LANES * sizeof(double)), aligned(8), may_alias));

struct Model {
  int actions, preferences, observations, entries;  // entries: padded to a multiple of LANES
  const double *gain, *offset;                      // (actions * preferences, entries)
  const double *observation;                        // (preferences, observations)
  bool revealed;                                    // the observation always is the preference
  double expertise, discount, cost_scale;
};

struct Xoshiro {  // xoshiro256+, Blackman & Vigna
  uint64_t s[4];
  explicit Xoshiro(uint64_t seed) {
    for (auto &word : s) {  // splitmix64
      uint64_t z = (seed += 0x9e3779b97f4a7c15u);
      z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
      z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
      word = z ^ (z >> 31);
    }
  }
  inline uint64_t word() {
    const uint64_t result = s[0] + s[3], t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = (s[3] << 45) | (s[3] >> 19);
    return result;
  }
  inline double uniform() { return static_cast<double>(word() >> 11) * 0x1.0p-53; }
  // Bits are taken from the top of one number after the other.
  uint64_t left = 0;
  int bits_left = 0;
  inline int bits(int count) {
    if (bits_left < count) {
      left = word();
      bits_left = 64;
    }
    const int found = static_cast<int>(left >> (64 - count));
    left <<= count;
    bits_left -= count;
    return found;
  }
};

// Tables by count, kept between calls.
struct Tables {
  std::vector<double> root_log, inverse_root, inverse;
  void grow(size_t size) {
    if (inverse.size() >= size) return;
    root_log.resize(size), inverse_root.resize(size), inverse.resize(size);
    for (size_t n = 0; n < size; ++n) {
      // the first two are log 0 and log 1: positive, so that (>0) * inf = inf, but too small to change a score
      root_log[n] = n < 2 ? 1e-300 : std::sqrt(std::log(static_cast<double>(n)));
      inverse_root[n] = n ? 1 / std::sqrt(static_cast<double>(n)) : std::numeric_limits<double>::infinity();
      inverse[n] = n ? 1.0 / static_cast<double>(n) : 0;
    }
  }
};

// Memory kept between calls.
struct Arena {
  void *memory = nullptr;
  size_t bytes = 0;
  void *take(size_t wanted) {
    if (wanted > bytes) {
      std::free(memory);
      bytes = (wanted + 63) / 64 * 64;
      memory = std::aligned_alloc(64, bytes);
      if (!memory) throw std::bad_alloc();
    }
    return memory;
  }
};

Tables tables;
Arena node_arena, path_arena;

inline double sum(const Lanes &v) { return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7])); }

inline int draw(const double *probabilities, int size, double threshold) {
  for (int i = 0; i < size - 1; ++i) {
    threshold -= probabilities[i];
    if (threshold < 0) return i;
  }
  return size - 1;
}

// A node's record when the numbers are known: fixed offsets. Otherwise the same fields at computed ones.
template <int A, int O>
struct Node {
  double value[A];
  double best;    // V(h), for the max backup
  double reward;  // of the step that leads here, where it is always the same
  int32_t visited;
  int32_t tried[A];
  int32_t child[A * O];
  int8_t sure[A];  // the preference that is always chosen, or UNKNOWN
  int8_t next;     // the action that the next descent chooses here
};

template <int A, int O>
struct Nodes {
  Node<A, O> *nodes;
  static size_t bytes(int, int) { return (sizeof(Node<A, O>) + 63) / 64 * 64; }
  static constexpr size_t STRIDE = (sizeof(Node<A, O>) + 63) / 64 * 64;
  Nodes(void *memory, int, int) : nodes(static_cast<Node<A, O> *>(memory)) {}
  inline Node<A, O> &at(int i) const {
    return *reinterpret_cast<Node<A, O> *>(reinterpret_cast<char *>(nodes) + static_cast<size_t>(i) * STRIDE);
  }
  inline double *value(int i) const { return at(i).value; }
  inline double &best(int i) const { return at(i).best; }
  inline int32_t &visited(int i) const { return at(i).visited; }
  inline int32_t *tried(int i) const { return at(i).tried; }
  inline int32_t *child(int i) const { return at(i).child; }
  inline double &reward(int i) const { return at(i).reward; }
  inline int8_t *sure(int i) const { return at(i).sure; }
  inline int8_t &next(int i) const { return at(i).next; }
};

template <>
struct Nodes<0, 0> {
  char *memory;
  size_t actions, children, stride;
  static size_t bytes(int A, int O) {
    return (sizeof(double) * (A + 2) + sizeof(int32_t) * (1 + A + static_cast<size_t>(A) * O) + A + 1 + 15) / 16 * 16;
  }
  Nodes(void *m, int A, int O)
      : memory(static_cast<char *>(m)), actions(A), children(static_cast<size_t>(A) * O), stride(bytes(A, O)) {}
  inline double *value(int i) const { return reinterpret_cast<double *>(memory + i * stride); }
  inline double &best(int i) const { return value(i)[actions]; }
  inline double &reward(int i) const { return value(i)[actions + 1]; }
  inline int32_t *ints(int i) const { return reinterpret_cast<int32_t *>(value(i) + actions + 2); }
  inline int32_t &visited(int i) const { return *ints(i); }
  inline int32_t *tried(int i) const { return ints(i) + 1; }
  inline int32_t *child(int i) const { return ints(i) + 1 + actions; }
  inline int8_t *sure(int i) const { return reinterpret_cast<int8_t *>(child(i) + children); }
  inline int8_t &next(int i) const { return sure(i)[actions]; }
};

constexpr int8_t UNKNOWN = -1;

struct Step {
  int32_t node;
  int16_t action, row;
  double reward;
};

enum class Choice { uniform, cheapest, soft };

// BLOCKS: vectors of a state, or 0 if only known at run time. KEEP: nodes keep what is always the same.
template <int A, int U, int BLOCKS, Choice CHOICE, bool MAXIMISE, bool KEEP>
double grow(const Model &m, const double *states, const double *weights, int particles, int descents,
            double exploration, uint64_t seed, double *values, int64_t *tried_out) {
  const int actions = A ? A : m.actions, preferences = U ? U : m.preferences;
  const int observations = U ? U : m.observations;  // a template argument U is used with revealed observations only
  const int blocks = BLOCKS ? BLOCKS : m.entries / LANES;
  const bool revealed = U ? true : m.revealed;
  const double discount = m.discount, scale = m.cost_scale;
  Xoshiro rng(seed);
  tables.grow(static_cast<size_t>(descents) + 2);
  using Storage = Nodes<A, U>;
  const Storage tree(node_arena.take(Storage::bytes(actions, observations) * (descents + 1)), actions, observations);
  Step *path = static_cast<Step *>(path_arena.take(sizeof(Step) * (descents + 1)));
  const double *root_log = tables.root_log.data(), *inverse_root = tables.inverse_root.data();
  const double *inverse = tables.inverse.data();
  const double c = exploration > 0 ? exploration : 1e-300;  // 0 * inf would be NaN

  auto make = [&](int i) {
    for (int a = 0; a < actions; ++a) tree.value(i)[a] = 0, tree.tried(i)[a] = 0;
    for (int k = 0; k < actions * observations; ++k) tree.child(i)[k] = -1;
    tree.best(i) = 0;
    tree.visited(i) = 1;
    tree.next(i) = 0;
    if (KEEP)
      for (int a = 0; a < actions; ++a) tree.sure(i)[a] = UNKNOWN;
  };
  // The action for the next descent: known as soon as this one is backed up, long before the next one comes along.
  auto ucb1 = [&](int node) {
    const double *value = tree.value(node);
    const int32_t *tried = tree.tried(node);
    const double width = c * root_log[tree.visited(node)++];
    int action = 0;
    double best = value[0] + width * inverse_root[tried[0]];
    for (int a = 1; a < actions; ++a) {
      const double score = value[a] + width * inverse_root[tried[a]];
      const bool better = score > best;
      action = better ? a : action;
      best = better ? score : best;
    }
    return action;
  };
  const int bits = preferences & (preferences - 1) ? 0 : __builtin_ctz(preferences);
  int used = 1;
  make(0);
  int64_t steps = 0;
  Lanes fixed[BLOCKS ? BLOCKS : 1];
  std::vector<double> heap(BLOCKS ? 0 : m.entries), some_costs(U ? 0 : preferences), some_chances(U ? 0 : preferences);
  double own_costs[U ? U : 1], own_chances[U ? U : 1];
  double *costs = U ? own_costs : some_costs.data(), *chances = U ? own_chances : some_chances.data();
  Lanes *state = BLOCKS ? fixed : reinterpret_cast<Lanes *>(heap.data());

  for (int descent = 0; descent < descents; ++descent) {
    const int particle = particles > 1 ? draw(weights, particles, rng.uniform()) : 0;
    const Lanes *start = reinterpret_cast<const Lanes *>(states) + static_cast<size_t>(particle) * blocks;
    for (int j = 0; j < blocks; ++j) state[j] = start[j];
    int node = 0, depth = 0, simulated = 0;  // `simulated`: how many steps are in the state
    while (node >= 0) {
      const int action = tree.next(node);
      if (KEEP) {
        const int always = tree.sure(node)[action];
        if (always != UNKNOWN) {
          const int32_t child = tree.child(node)[action * observations + always];
          const int row = action * preferences + always;
          path[depth++] = {node, static_cast<int16_t>(action), static_cast<int16_t>(row), tree.reward(child)};
          node = child;
          continue;
        }
        for (; simulated < depth; ++simulated) {
          const size_t first = static_cast<size_t>(path[simulated].row) * blocks;
          const Lanes *gain = reinterpret_cast<const Lanes *>(m.gain) + first;
          const Lanes *offset = reinterpret_cast<const Lanes *>(m.offset) + first;
          for (int j = 0; j < blocks; ++j) state[j] = gain[j] * state[j] + offset[j];
        }
      }
      // Eq. 4
      const Lanes *gain = reinterpret_cast<const Lanes *>(m.gain) + static_cast<size_t>(action) * preferences * blocks;
      const Lanes *offset = reinterpret_cast<const Lanes *>(m.offset) + (gain - reinterpret_cast<const Lanes *>(m.gain));
      int preference = 0;
      bool certain = false;
      double cost = 0;
      if (CHOICE == Choice::uniform) {
        preference = bits ? rng.bits(bits) : static_cast<int>(rng.uniform() * preferences);
      } else {
        double lowest = std::numeric_limits<double>::infinity();
        for (int u = 0; u < preferences; ++u) {
          Lanes total = {};
          for (int j = 0; j < blocks; ++j) {
            const Lanes f = gain[u * blocks + j] * state[j] + offset[u * blocks + j];
            total += f * f;
          }
          costs[u] = sum(total) * scale;
          if (costs[u] < lowest) lowest = costs[u], preference = u;
        }
        double total = 0;
        for (int u = 0; u < preferences; ++u) {
          const double excess = costs[u] - lowest;
          if (CHOICE == Choice::cheapest) {
            chances[u] = excess == 0 ? 1.0 : 0.0;
          } else {
            chances[u] = excess == 0 ? 1.0 : std::exp(-m.expertise * excess);
          }
          total += chances[u];
        }
        // one uniform draw, as in the other search; scaled by the total instead of dividing every probability
        const double threshold = rng.uniform() * total;
        certain = CHOICE == Choice::cheapest && total == 1;
        if (total > 1) preference = draw(chances, preferences, threshold);  // else the cheapest is the only one
        cost = costs[preference];
      }
      gain += preference * blocks, offset += preference * blocks;
      if (CHOICE != Choice::uniform) {  // its cost is known from the choice
        for (int j = 0; j < blocks; ++j) state[j] = gain[j] * state[j] + offset[j];
      } else {  // step and reward in one pass
        Lanes total = {}, other = {};
        int j = 0;
        for (; j + 1 < blocks; j += 2) {
          const Lanes f = gain[j] * state[j] + offset[j], g = gain[j + 1] * state[j + 1] + offset[j + 1];
          state[j] = f, state[j + 1] = g;
          total += f * f, other += g * g;
        }
        if (j < blocks) {
          const Lanes f = gain[j] * state[j] + offset[j];
          state[j] = f;
          total += f * f;
        }
        cost = scale * sum(total + other);
      }
      const int seen = revealed ? preference
                             : draw(m.observation + static_cast<size_t>(preference) * observations, observations,
                                    rng.uniform());
      path[depth++] = {node, static_cast<int16_t>(action), 0, -cost};
      simulated = depth;
      const int left = node;
      int32_t &child = tree.child(node)[action * observations + seen];
      node = child;
      if (node < 0) {
        child = used;
        make(used);
        if (KEEP && certain) tree.sure(left)[action] = static_cast<int8_t>(preference), tree.reward(used) = -cost;
        ++used;
      }
    }
    steps += depth;
    double carried = 0;  // mean: the return below; max: n V - n' V' of the successor, a new leaf's being 0
    for (int level = depth - 1; level >= 0; --level) {
      const Step &step = path[level];
      const int n = ++tree.tried(step.node)[step.action];
      double *value = tree.value(step.node);
      carried = step.reward + discount * carried;
      value[step.action] += (carried - value[step.action]) * inverse[n];
      if (MAXIMISE) {
        double &best = tree.best(step.node);
        double after = -std::numeric_limits<double>::infinity();
        for (int a = 0; a < actions; ++a) {
          const double v = tree.tried(step.node)[a] ? value[a] : -std::numeric_limits<double>::infinity();
          after = v > after ? v : after;
        }
        const double visited = tree.visited(step.node) + 1;
        carried = visited * after - (visited - 1) * best;
        best = after;
      }
      tree.next(step.node) = static_cast<int8_t>(ucb1(step.node));
    }
  }
  for (int a = 0; a < actions; ++a) values[a] = tree.value(0)[a], tried_out[a] = tree.tried(0)[a];
  return static_cast<double>(steps) / descents;
}

template <int A, int U, int BLOCKS, typename... Rest>
double by_choice(const Model &m, bool maximise, const double *states, const double *weights, int particles,
                 Rest... rest) {
  const auto choose = [&](auto most, auto least) {
    return maximise ? most(m, states, weights, particles, rest...) : least(m, states, weights, particles, rest...);
  };
  using C = Choice;
  if (m.expertise == 0)
    return choose(grow<A, U, BLOCKS, C::uniform, true, false>, grow<A, U, BLOCKS, C::uniform, false, false>);
  if (std::isinf(m.expertise))
    return particles == 1 && m.revealed
               ? choose(grow<A, U, BLOCKS, C::cheapest, true, true>, grow<A, U, BLOCKS, C::cheapest, false, true>)
               : choose(grow<A, U, BLOCKS, C::cheapest, true, false>, grow<A, U, BLOCKS, C::cheapest, false, false>);
  return choose(grow<A, U, BLOCKS, C::soft, true, false>, grow<A, U, BLOCKS, C::soft, false, false>);
}

template <int A, int U, typename... Rest>
double by_entries(const Model &m, Rest... rest) {
  switch (m.entries / LANES) {
    case 2: return by_choice<A, U, 2>(m, rest...);
    case 3: return by_choice<A, U, 3>(m, rest...);
    case 4: return by_choice<A, U, 4>(m, rest...);
    case 5: return by_choice<A, U, 5>(m, rest...);
    case 6: return by_choice<A, U, 6>(m, rest...);
    case 10: return by_choice<A, U, 10>(m, rest...);
    default: return by_choice<A, U, 0>(m, rest...);
  }
}

}  // namespace

// Grows a tree; writes the root's values and counts of every action and returns the mean depth of a descent.
// Rows of gain, offset and states hold `entries` numbers, padded with zeros to a multiple of 8. Not thread-safe.
extern "C" double search(int actions, int preferences, int observations, int entries, const double *gain,
                         const double *offset, const double *observation, int revealed, double expertise,
                         double discount, double cost_scale, const double *states, const double *weights,
                         int particles, int descents, double exploration, int maximise, uint64_t seed,
                         double *values, int64_t *tried) {
  const Model m{actions, preferences, observations, entries,  gain,       offset,
                observation, revealed != 0, expertise, discount, cost_scale};
  const bool max = maximise != 0;
  if (m.revealed && actions == 2 && preferences == 2)
    return by_entries<2, 2>(m, max, states, weights, particles, descents, exploration, seed, values, tried);
  if (m.revealed && actions == 3 && preferences == 2)
    return by_choice<3, 2, 0>(m, max, states, weights, particles, descents, exploration, seed, values, tried);
  return by_choice<0, 0, 0>(m, max, states, weights, particles, descents, exploration, seed, values, tried);
}
