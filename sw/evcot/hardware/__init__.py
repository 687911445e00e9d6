# SPDX-License-Identifier: Apache-2.0
"""What RTL, golden model and host share: the contract, the register map, and exact twins of modules."""
