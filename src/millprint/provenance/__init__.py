"""What a run was made from, by whom and when: its lineage, its Workflow Run RO-Crate, and a check of copies."""
