# SPDX-License-Identifier: Apache-2.0
# Proofs by bounded model checking: test/proof/<path of the source>/proof_*.c, each with planted faults that it must
# find.

.PHONY: proofs check-proofs check-all-proofs
proofs: build/setup/proofs $(GENERATED)
	@$(PYTHON) test/proof/run_proofs.py --only '$(ONLY)'
check-proofs: build/setup/check $(GENERATED)
	@$(PYTHON) test/proof/run_proofs.py --quick
check-all-proofs: build/setup/full
	+@$(MAKE) --no-print-directory proofs ONLY=
